# SPDX-License-Identifier: Apache-2.0
# nvcc and its options, for VESTA_CUDA=ON. nvcc compiles only kernels (docs/architecture.md).
if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES)
  set(CMAKE_CUDA_ARCHITECTURES 90 CACHE STRING "GPU architectures to compile for: 90 is Hopper")
endif()
if(NOT DEFINED CMAKE_CUDA_HOST_COMPILER AND NOT DEFINED ENV{CUDAHOSTCXX})
  set(CMAKE_CUDA_HOST_COMPILER ${CMAKE_CXX_COMPILER} CACHE FILEPATH "Compiler of the host side of CUDA files")
endif()
find_program(VESTA_NVCC nvcc HINTS ENV CUDACXX ENV CUDA_PATH PATHS /usr/local/cuda PATH_SUFFIXES bin)
if(NOT DEFINED CMAKE_CUDA_COMPILER AND VESTA_NVCC)
  set(CMAKE_CUDA_COMPILER ${VESTA_NVCC})
endif()
enable_language(CUDA)
find_package(CUDAToolkit REQUIRED)

# CMake 3.25 does not know C++20 for nvcc: the standard 20 passes no flag and must not be required. -fmad=false is
# nvcc's -ffp-contract=off. -lineinfo gives source lines to tools without loss of speed. Files for nvcc must not include
# fmt, because nvcc cannot compile version 9 as C++20.
set(CMAKE_CUDA_STANDARD 20)
set(CMAKE_CUDA_STANDARD_REQUIRED OFF)
string(APPEND CMAKE_CUDA_FLAGS " -std=c++20 -fmad=false --expt-relaxed-constexpr --extended-lambda -lineinfo -Xcompiler=-Wall,-Wextra,-Wshadow,-ffp-contract=off")
if(VESTA_WARNINGS_AS_ERRORS)
  string(APPEND CMAKE_CUDA_FLAGS " -Werror=all-warnings -Xcompiler=-Werror")
endif()

# Programs first search shared libraries in ../lib, where bench/gpu/pack.sh copies them. An RPATH, unlike a RUNPATH,
# also applies to libraries of libraries.
set(CMAKE_BUILD_RPATH "\$ORIGIN/../lib")
add_link_options(LINKER:--disable-new-dtags)
