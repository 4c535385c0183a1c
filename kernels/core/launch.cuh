// SPDX-License-Identifier: Apache-2.0
// Launches functors and block kernels on the device, in the library's stream.
#pragma once

#include <type_traits>

#include "kernels/core/block_kernel.h"
#include "kernels/core/cuda_runtime.cuh"
#include "kernels/core/device_kernels.h"

namespace vesta::device {

// The Block of block_kernel.h on a GPU.
struct CudaBlock {
#if defined(__CUDA_ARCH__)
  VESTA_HD int thread() const { return static_cast<int>(threadIdx.x); }
  VESTA_HD Index id() const { return blockIdx.x; }
  VESTA_HD void Sync() const { __syncthreads(); }
  VESTA_HD int Count(bool value) const { return __syncthreads_count(value ? 1 : 0); }
#else
  // nvcc's host pass compiles kernels too, but never runs them.
  VESTA_HD int thread() const { return 0; }
  VESTA_HD Index id() const { return 0; }
  VESTA_HD void Sync() const {}
  VESTA_HD int Count(bool value) const { return value ? 1 : 0; }
#endif
};

template <class Kernel>
__global__ void __launch_bounds__(Kernel::kThreads) RunBlockKernel(const Kernel kernel) {
  __shared__ typename Kernel::Shared shared;
  CudaBlock block;
  kernel(block, shared);
}

// Threads per block of ForEach: few, so that functions with many registers still occupy most of a multiprocessor.
inline constexpr int kForEachThreads = 128;
// F::kMinBlocks, if defined: the minimum number of blocks that must fit on a multiprocessor at once. If it is 1, the
// compiler may use all registers. Without kMinBlocks (0), it may spill values to memory to fit one more block.
template <class F>
constexpr int MinBlocks() {
  if constexpr (requires { F::kMinBlocks; }) {
    return F::kMinBlocks;
  } else {
    return 0;
  }
}

template <class F>
__global__ void __launch_bounds__(kForEachThreads, MinBlocks<F>()) RunForEach(Index count, const F f) {
  const Index step = Index{kForEachThreads} * gridDim.x;
  for (Index i = Index{kForEachThreads} * blockIdx.x + threadIdx.x; i < count; i += step) f(i);
}

// name: the kernel's name in reports.
template <class Kernel>
void Launch(const Kernel& kernel, Index blocks, const char* name) {
  static_assert(sizeof(typename Kernel::Shared) <= 48 * 1024);
  if (blocks == 0) return;
  static const bool noted = (RegisterKernel(name, reinterpret_cast<const void*>(&RunBlockKernel<Kernel>)), true);
  static_cast<void>(noted);
  LaunchOrThrow(
      [&] {
        RunBlockKernel<<<static_cast<unsigned>(blocks), Kernel::kThreads, 0, Stream()>>>(kernel);
        return FoundMemory(cudaGetLastError(), name);
      },
      name);
}

// Calls f(i) for each i in [0, count). name: the kernel's name in reports.
template <class F>
void ForEach(Index count, const F& f, const char* name) {
  if (count == 0) return;
  static const bool noted = (RegisterKernel(name, reinterpret_cast<const void*>(&RunForEach<F>)), true);
  static_cast<void>(noted);
  // This many blocks are enough for the largest GPUs; the loop inside the kernel covers the remaining indices.
  constexpr Index kMaxBlocks = 132 * 128;
  const Index needed = (count + kForEachThreads - 1) / kForEachThreads;
  const auto blocks = static_cast<unsigned>(needed < kMaxBlocks ? needed : kMaxBlocks);
  LaunchOrThrow(
      [&] {
        RunForEach<<<blocks, kForEachThreads, 0, Stream()>>>(count, f);
        return FoundMemory(cudaGetLastError(), name);
      },
      name);
}

}  // namespace vesta::device
