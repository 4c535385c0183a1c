// SPDX-License-Identifier: Apache-2.0
// Replaces kernels/core/launch.cuh in builds that compile .cu files as plain C++ for the emulated GPU
// (tests/support/emulated_device.h).
#pragma once

#include "kernels/core/block_kernel.h"
#include "kernels/core/device_kernels.h"
#include "tests/support/emulated_block.h"
#include "tests/support/emulated_device.h"

// Keywords of nvcc.
#define __device__

namespace vesta::device {

template <class Kernel>
void Launch(const Kernel& kernel, Index blocks, const char* name) {
  static_assert(sizeof(typename Kernel::Shared) <= 48 * 1024);
  // One object per number of threads, because making its stacks takes longer than most kernels.
  thread_local test::FiberBlock fibers(Kernel::kThreads, test::ThreadOrder::kShuffled, 1);
  if (blocks == 0) return;
  LaunchOrThrow(test::LaunchFindsMemory, name);
  test::Emulate(kernel, blocks, fibers);
}

// In reverse, to reveal a dependence on the order.
template <class F>
void ForEach(Index count, const F& f, const char* name) {
  if (count == 0) return;
  LaunchOrThrow(test::LaunchFindsMemory, name);
  for (Index i = count; i-- > 0;) f(i);
}

inline void atomicAdd(unsigned long long* sum, unsigned long long value) { *sum += value; }

}  // namespace vesta::device
