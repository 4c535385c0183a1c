# SPDX-License-Identifier: Apache-2.0
include(GNUInstallDirs)

# The libraries that cmake --install installs. BUILD_SHARED_LIBS makes them shared; all others are static.
set(VESTA_INSTALLED_LIBRARIES
  core ranks solver distributed toy bundle_adjustment pose_graph ceres_bridge mpi)

# vesta_library(name SOURCES a.cpp ... [LINK targets ...])
# Adds a library vesta_<name> with the alias vesta::<name>. LINK is PUBLIC: the links are the dependencies in
# docs/architecture.md. Before version 1.0, a minor version may change the binary interface, so it is part of the
# SOVERSION.
function(vesta_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  set(type STATIC)
  if(BUILD_SHARED_LIBS AND name IN_LIST VESTA_INSTALLED_LIBRARIES)
    set(type SHARED)
  endif()
  add_library(vesta_${name} ${type} ${ARG_SOURCES})
  add_library(vesta::${name} ALIAS vesta_${name})
  target_include_directories(vesta_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/vesta>)
  target_compile_features(vesta_${name} PUBLIC cxx_std_20)
  set_target_properties(vesta_${name} PROPERTIES
    EXPORT_NAME ${name}
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} INSTALL_RPATH "$ORIGIN")
  target_link_libraries(vesta_${name} PUBLIC ${ARG_LINK})
endfunction()

# vesta_cuda_library(name SOURCES a.cu b.cpp ... [LINK targets ...])
# Like vesta_library, for device code and code that calls CUDA; only if VESTA_CUDA is ON. These libraries are separate
# from the host libraries and are not installed. In every build the tests also compile the sources for the emulated
# device (vesta_emulated_library in tests/support/CMakeLists.txt).
function(vesta_cuda_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  list(TRANSFORM ARG_SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  set_property(GLOBAL PROPERTY vesta_sources_${name} ${ARG_SOURCES})
  if(VESTA_CUDA)
    add_library(vesta_${name} STATIC ${ARG_SOURCES})
    add_library(vesta::${name} ALIAS vesta_${name})
    set_target_properties(vesta_${name} PROPERTIES UNITY_BUILD OFF)
    target_link_libraries(vesta_${name} PUBLIC ${ARG_LINK} PRIVATE CUDA::cudart_static)
  endif()
endfunction()

# vesta_check_alignment(target)
# Checks alignment under the undefined-behaviour sanitizer, in libraries that read numbers from bytes.
function(vesta_check_alignment target)
  if(VESTA_SANITIZE MATCHES undefined)
    target_compile_options(${target} PRIVATE -fsanitize=alignment)
  endif()
endfunction()

# vesta_no_unity(a.cpp ...)
# Excludes sources from unity builds (CMAKE_UNITY_BUILD), because they share a name in unnamed namespaces with another
# source. Call it in the folder of their target.
function(vesta_no_unity)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# vesta_simd_sources(target a.simd.cpp ...)
# Compiles each file once per instruction set into the target, in the inline namespace VESTA_ISA (kernels/math/isa.h).
# kernels/core/cpu_dispatch.h selects one at run time.
function(vesta_simd_sources target)
  set(isas baseline)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    list(APPEND isas avx2 avx512)
  endif()
  set(flags_baseline "")
  set(flags_avx2 -mavx2 -mfma)
  set(flags_avx512 -mavx2 -mfma -mavx512f -mavx512cd -mavx512bw -mavx512dq -mavx512vl -mprefer-vector-width=512)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # The AVX-512 intrinsics of gcc 12 read an intentionally uninitialised variable (gcc bug 105593).
    list(APPEND flags_avx512 -Wno-uninitialized -Wno-maybe-uninitialized)
  endif()
  set(flags_sanitized "")
  if(VESTA_SANITIZE MATCHES address)
    # These files inline thousands of small objects, for which use-after-scope checks take minutes to compile. Their
    # loads need no alignment. The wider instruction sets have the arithmetic of the baseline, so only the baseline is
    # checked for undefined behaviour. Code without inlining, and checks by call of more than 16 bytes, are slow: both
    # together make tests three to six times slower.
    set(flags_sanitized -O1 -finline-functions -finline-small-functions -fno-sanitize-address-use-after-scope
      -fno-sanitize=alignment)
    if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
      list(APPEND flags_sanitized --param=asan-instrumentation-with-call-threshold=1000000)
    endif()
    list(APPEND flags_avx2 -fno-sanitize=undefined)
    list(APPEND flags_avx512 -fno-sanitize=undefined)
  endif()
  if(VESTA_SANITIZE MATCHES thread)
    # Without inlining, values go through memory, where each access is checked.
    set(flags_sanitized -O2)
  endif()
  foreach(isa IN LISTS isas)
    set(objects ${target}_${isa})
    add_library(${objects} OBJECT ${ARGN})
    target_include_directories(${objects} PRIVATE ${PROJECT_SOURCE_DIR})
    target_compile_definitions(${objects} PRIVATE VESTA_ISA=${isa})
    target_compile_options(${objects} PRIVATE ${flags_${isa}} ${flags_sanitized})
    target_link_libraries(${objects} PRIVATE xsimd)
    set_target_properties(${objects} PROPERTIES UNITY_BUILD OFF)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${objects}>)
  endforeach()
endfunction()

# vesta_test(name SOURCES a_test.cpp ... [LINK targets ...] [LABELS labels ...] [TIMEOUT seconds] [PREFIX p])
# Adds a test program with one ctest entry per GoogleTest case, named PREFIX + case. Under sanitizers there is one entry
# for the program, whose start takes longer than most cases. The target tests_<label> builds all programs with this
# label. A test takes at most 10 s alone on two cores; its time limit is at least ten times that, for busy machines.
set(VESTA_TEST_LABELS
  unit      # the default
  asan      # runs under the address sanitizer; covers each mechanism once
  threads   # runs under the thread sanitizer; covers each mechanism once
  ceres     # compares with Ceres, or compiles slowly
  numerics  # many values through unit-tested code
  data      # whole problems of the field
  memory    # measures memory
  program   # the program `vesta`, as users call it
  mpi       # several processes
  tools     # scripts
  slow      # can be skipped in a first run
  cuda)     # needs a GPU
function(vesta_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT;PREFIX" "SOURCES;LINK;LABELS" ${ARGN})
  if(NOT ARG_LABELS)
    set(ARG_LABELS unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  foreach(label IN LISTS ARG_LABELS)
    if(NOT label IN_LIST VESTA_TEST_LABELS)
      message(FATAL_ERROR "${name}: no label \"${label}\"; cmake/Targets.cmake lists them")
    endif()
  endforeach()
  add_executable(${name} ${ARG_SOURCES})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LINK} GTest::gtest_main GTest::gmock)
  # For the code of the tests only, which need not be fast. Optimising Eigen takes long, and longer with sanitizer
  # checks; alignment checks alone take a fifth of the compile time.
  if(VESTA_SANITIZE)
    target_compile_options(${name} PRIVATE ${VESTA_SANITIZED_TEST_OPTIONS})
    target_precompile_headers(${name} REUSE_FROM sanitized_test_headers)
  else()
    target_compile_options(${name} PRIVATE ${VESTA_TEST_OPTIONS})
  endif()
  foreach(label IN LISTS ARG_LABELS)
    if(NOT TARGET tests_${label})
      add_custom_target(tests_${label})
    endif()
    add_dependencies(tests_${label} ${name})
  endforeach()
  if(VESTA_SANITIZE)
    add_test(NAME ${name} COMMAND ${name} --gtest_brief=1 WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
    set_tests_properties(${name} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT 1200)
    return()
  endif()
  include(GoogleTest)
  set(prefix "")
  if(ARG_PREFIX)  # CMake 3.31 rejects an empty prefix
    set(prefix TEST_PREFIX "${ARG_PREFIX}")
  endif()
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 ${prefix} PROPERTIES TIMEOUT ${ARG_TIMEOUT}
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  # In a separate file: gtest_discover_tests would treat the second label as the name of a property.
  set(labels_file ${CMAKE_CURRENT_BINARY_DIR}/${name}_labels.cmake)
  file(CONFIGURE OUTPUT ${labels_file} @ONLY CONTENT
    "foreach(test IN LISTS @name@_TESTS)\n  set_tests_properties(\"\${test}\" PROPERTIES LABELS \"@ARG_LABELS@\")\nendforeach()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${labels_file})
endfunction()

# vesta_commit_source(target variable header)
# Adds a source to the target that defines the string `variable`, declared in `header`, as the commit of the build.
function(vesta_commit_source target variable header)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${target}_commit.cpp)
  add_custom_target(${target}_commit
    COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -DOUTPUT=${source} -DVARIABLE=${variable} -DHEADER=${header}
      -P ${PROJECT_SOURCE_DIR}/cmake/WriteCommit.cmake
    BYPRODUCTS ${source} VERBATIM)
  target_sources(${target} PRIVATE ${source})
  add_dependencies(${target} ${target}_commit)
endfunction()

# vesta_bench(name SOURCES a.cpp ... [LINK targets ...])
# Adds a benchmark program build/<preset>/bench/<name>.
function(vesta_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bench)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LINK})
endfunction()
