// Stands in for kernels/core/launch.cuh where code of a GPU runs on the host (emulated_device.cpp): in targets that
// have tests/support/emulated_device in front of the folders they include from.
#pragma once

#include "tests/support/emulated_block.h"

namespace vesta::device {

// Threads in an order of their own, each index from the last to the first: nothing may depend on either.
template <class Kernel>
void Launch(const Kernel& kernel, Index blocks, const char*) {
  static_assert(sizeof(typename Kernel::Shared) <= 48 * 1024);
  if (blocks > 0) test::Emulate(kernel, blocks, test::ThreadOrder::kShuffled);
}

template <class F>
void ForEach(Index count, const F& f, const char*) {
  for (Index i = count - 1; i >= 0; --i) f(i);
}

}  // namespace vesta::device
