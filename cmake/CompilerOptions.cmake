# SPDX-License-Identifier: Apache-2.0
# Language level, warnings, sanitizers and floating-point rules, once for every C++ target. For nvcc: cmake/Cuda.cmake.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})
if(PROJECT_IS_TOP_LEVEL AND NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

set(options -Wall -Wextra -Wpedantic -Wshadow -Wno-ignored-attributes)
if(CMAKE_UNITY_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # Of sources that are compiled as one, each is taken for a header whose class has members from an unnamed namespace.
  list(APPEND options -Wno-subobject-linkage)
endif()
if(VESTA_WARNINGS_AS_ERRORS)
  list(APPEND options -Werror)
endif()

if(PROJECT_IS_TOP_LEVEL AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # No hunt for garbage in the compiler's first gigabyte: up to a fifth less time, and a third more memory.
  list(APPEND options --param=ggc-min-heapsize=1000000)
endif()

# With contraction left to the compiler, one template gives different values as float and inside a dual number,
# and a flipped cut-off drops a whole term. Fused multiply-adds are written out where they are wanted.
list(APPEND options -ffp-contract=off)

# No folder of the machine that built it in what is built: the same bits wherever the sources lie, and the same key in a cache.
list(APPEND options -ffile-prefix-map=${PROJECT_SOURCE_DIR}/=)

if(VESTA_SANITIZE)
  list(APPEND options -fsanitize=${VESTA_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -g1)
  if(VESTA_SANITIZE MATCHES address)
    # The address sanitizer reports these two as well.
    list(APPEND options -fno-sanitize=null,object-size)
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
      # Whether each load is aligned takes a third of the time to compile. What reads photographs
      # and splats asks it (vesta_check_alignment), and so do all libraries in the preset fuzz, whose compiler makes less of it.
      list(APPEND options -fno-sanitize=alignment)
    endif()
  endif()
  set(VESTA_SANITIZED_TEST_OPTIONS -Og -fno-sanitize=alignment)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # The checks cost the compiler more than the code they are in: the same checks as calls where a function has more
    # than a few of them.
    list(APPEND options --param=asan-instrumentation-with-call-threshold=20)
  endif()
  add_link_options(-fsanitize=${VESTA_SANITIZE})
  # Eigen allocates in another way under the address sanitizer; a static Ceres, compiled without it, brings the usual one,
  # and the linker takes one of both for all.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()
add_compile_options("$<$<COMPILE_LANGUAGE:CXX>:${options}>")
