# SPDX-License-Identifier: Apache-2.0
# nvcc and its options; included when VESTA_CUDA is ON. nvcc compiles kernels only (docs/architecture.md).
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

# CMake 3.25 knows no C++20 for nvcc: the standard 20 passes no flag, and must not be required. -fmad=false is nvcc's
# counterpart of -ffp-contract=off. -lineinfo names the lines of the source to tools, and costs no speed. Files for nvcc
# keep clear of fmt: version 9 does not compile there as C++20.
set(CMAKE_CUDA_STANDARD 20)
set(CMAKE_CUDA_STANDARD_REQUIRED OFF)
string(APPEND CMAKE_CUDA_FLAGS " -std=c++20 -fmad=false --expt-relaxed-constexpr --extended-lambda -lineinfo -Xcompiler=-Wall,-Wextra,-Wshadow,-ffp-contract=off")
if(VESTA_WARNINGS_AS_ERRORS)
  string(APPEND CMAKE_CUDA_FLAGS " -Werror=all-warnings -Xcompiler=-Werror")
endif()

# Programs find shared libraries in lib/ beside their folder first, where bench/gpu/pack.sh gathers them; as RPATH, for
# the libraries of libraries too.
set(CMAKE_BUILD_RPATH "\$ORIGIN/../lib")
add_link_options(LINKER:--disable-new-dtags)
