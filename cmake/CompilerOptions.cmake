# SPDX-License-Identifier: Apache-2.0
# Language standard, warnings, sanitizers and floating-point rules of all C++ targets (nvcc: cmake/Cuda.cmake).
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
  # GCC treats each source of a unity build as a header, and warns if a class has members from an unnamed namespace.
  list(APPEND options -Wno-subobject-linkage)
endif()
if(VESTA_WARNINGS_AS_ERRORS)
  list(APPEND options -Werror)
endif()

if(PROJECT_IS_TOP_LEVEL AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # No garbage collection in the compiler's first gigabyte: up to 20 % less time, and a third more memory.
  list(APPEND options --param=ggc-min-heapsize=1000000)
endif()

# Contracted multiply-adds would give different values for float and for dual numbers in one template. A different
# result of a cut-off test would then drop a whole term. The code calls fused multiply-adds explicitly.
list(APPEND options -ffp-contract=off)

# Without the source folder in file names, bits and ccache keys do not depend on it.
list(APPEND options -ffile-prefix-map=${PROJECT_SOURCE_DIR}/=)

if(VESTA_SANITIZE)
  list(APPEND options -fsanitize=${VESTA_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -g1)
  if(VESTA_SANITIZE MATCHES address)
    # Reported by the address sanitizer too.
    list(APPEND options -fno-sanitize=null,object-size)
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
      # Alignment checks take a third of the compile time. Only the readers of photographs and splats have them
      # (vesta_check_alignment), and all libraries in the preset fuzz, whose compiler is faster at this.
      list(APPEND options -fno-sanitize=alignment)
    endif()
  endif()
  set(VESTA_SANITIZED_TEST_OPTIONS -Og -fno-sanitize=alignment)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # Inline checks take longer to compile than the code. Functions with more than a few checks use calls.
    list(APPEND options --param=asan-instrumentation-with-call-threshold=20)
  endif()
  add_link_options(-fsanitize=${VESTA_SANITIZE})
  # Under the address sanitizer Eigen would use another allocator than a static Ceres without it, and the linker would
  # use one of the two for both.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()
add_compile_options("$<$<COMPILE_LANGUAGE:CXX>:${options}>")
