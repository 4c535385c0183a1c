// SPDX-License-Identifier: Apache-2.0
// Stands in the place of kernels/core/launch.cuh where files for nvcc are compiled as plain C++: kernels run on the
// host, thread by thread (tests/support/emulated_device.h).
#pragma once

#include "kernels/core/block_kernel.h"
#include "kernels/core/device_kernels.h"
#include "tests/support/emulated_block.h"
#include "tests/support/emulated_device.h"

// What such files say of themselves to nvcc.
#define __device__

namespace vesta::device {

template <class Kernel>
void Launch(const Kernel& kernel, Index blocks, const char* name) {
  static_assert(sizeof(typename Kernel::Shared) <= 48 * 1024);
  // One for all launches: its stacks take longer to make than most kernels to run.
  thread_local test::FiberBlock fibers(Kernel::kThreads, test::ThreadOrder::kShuffled, 1);
  if (blocks == 0) return;
  LaunchOrThrow(test::LaunchFindsMemory, name);
  test::Emulate(kernel, blocks, fibers);
}

// Backwards: what depends on the order shows.
template <class F>
void ForEach(Index count, const F& f, const char* name) {
  if (count == 0) return;
  LaunchOrThrow(test::LaunchFindsMemory, name);
  for (Index i = count; i-- > 0;) f(i);
}

inline void atomicAdd(unsigned long long* sum, unsigned long long value) { *sum += value; }

}  // namespace vesta::device
