// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "kernels/core/sort.h"

namespace vesta {
namespace {

// Equal to std::stable_sort. Values are positions, which detect an unstable sort.
void Check(std::vector<KeyValue> expected) {
  HostBuffer<KeyValue> items, scratch;
  items.CopyFrom({expected.data(), static_cast<Index>(expected.size())});
  std::stable_sort(expected.begin(), expected.end(), [](KeyValue a, KeyValue b) { return a.key < b.key; });
  RadixSort(items, scratch);
  ASSERT_EQ(items.size(), static_cast<Index>(expected.size()));
  for (Index i = 0; i < items.size(); ++i) {
    ASSERT_EQ(items[i].key, expected[static_cast<std::size_t>(i)].key) << i;
    ASSERT_EQ(items[i].value, expected[static_cast<std::size_t>(i)].value) << i;
  }
}

// Each mask needs different passes of the sort.
TEST(RadixSort, IsTheStableSort) {
  std::mt19937 random(1);
  for (const std::uint32_t mask : {0xffffffffu, 0x7ffu, 0x3ff800u, 0xffc00000u, 0x00400001u, 0u}) {
    for (const std::uint32_t size : {0u, 1u, 2u, 1000u, 5000u}) {
      std::vector<KeyValue> items;
      for (std::uint32_t i = 0; i < size; ++i) items.push_back({static_cast<std::uint32_t>(random()) & mask, i});
      SCOPED_TRACE(testing::Message() << "mask " << mask << ", " << size << " items");
      Check(items);
    }
  }
}

TEST(RadixSort, ScratchOfAnotherSizeIsReused) {
  HostBuffer<KeyValue> items(3), scratch(7);
  items[0] = {5, 0}, items[1] = {0xffffffffu, 1}, items[2] = {0, 2};
  RadixSort(items, scratch);
  EXPECT_EQ(items[0].value, 2u);
  EXPECT_EQ(items[1].value, 0u);
  EXPECT_EQ(items[2].value, 1u);
}

}  // namespace
}  // namespace vesta
