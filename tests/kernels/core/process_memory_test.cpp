// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/process_memory.h"

#include <gtest/gtest.h>

#include <vector>

namespace vesta {
namespace {

TEST(ProcessMemory, CountsAllocatedMemory) {
  const double before = MemoryMib(), available = AvailableMemoryMib();
  EXPECT_GT(before, 0);
  EXPECT_GT(available, 0);
  EXPECT_LT(available, 1e9);
  constexpr int kMib = 200;
  const std::vector<char> taken(std::size_t{kMib} << 20, 1);
  EXPECT_GT(MemoryMib(), before + 0.9 * kMib);
  EXPECT_GE(PeakMemoryMib(), MemoryMib() - 1);
}

}  // namespace
}  // namespace vesta
