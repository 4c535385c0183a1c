// SPDX-License-Identifier: Apache-2.0
// Stable sorting of keys with values.
#pragma once

#include <array>
#include <cstdint>
#include <utility>

#include "kernels/core/buffer.h"

namespace vesta {

struct KeyValue {
  std::uint32_t key;
  std::uint32_t value;
};

// Stable least-significant-digit radix sort with three passes of 11 bits. A pass is skipped if all keys have the same
// digit. scratch is resized as needed; its contents are unspecified afterwards.
inline void RadixSort(HostBuffer<KeyValue>& items, HostBuffer<KeyValue>& scratch) {
  constexpr int kBits = 11, kBuckets = 1 << kBits, kPasses = 3;
  const Index n = items.size();
  scratch.ResizeForOverwrite(n);
  std::array<std::array<std::uint32_t, kBuckets>, kPasses> histogram{};
  for (const KeyValue& item : items) {
    for (int pass = 0; pass < kPasses; ++pass) {
      ++histogram[static_cast<std::size_t>(pass)][item.key >> (kBits * pass) & (kBuckets - 1)];
    }
  }
  for (int pass = 0; pass < kPasses; ++pass) {
    auto& count = histogram[static_cast<std::size_t>(pass)];
    const int shift = kBits * pass;
    if (n > 0 && count[items[0].key >> shift & (kBuckets - 1)] == static_cast<std::uint32_t>(n)) continue;
    std::uint32_t first = 0;
    for (std::uint32_t& c : count) first += std::exchange(c, first);
    for (const KeyValue& item : items) scratch[count[item.key >> shift & (kBuckets - 1)]++] = item;
    std::swap(items, scratch);
  }
}

// Sorting and running sums with the same interface for all memory spaces (GPU: device_sort.h). Results depend only on
// the input.
template <class Space>
struct Sorting;

template <>
struct Sorting<Host> {
  // Stable sort of the values by their keys. The keys are unspecified afterwards.
  static void ByKey(HostBuffer<std::uint32_t>& keys, HostBuffer<std::uint32_t>& values) {
    HostBuffer<KeyValue> items, scratch;
    items.ResizeForOverwrite(keys.size());
    for (Index i = 0; i < keys.size(); ++i) items[i] = {keys[i], values[i]};
    RadixSort(items, scratch);
    for (Index i = 0; i < keys.size(); ++i) values[i] = items[i].value;
  }

  // sums[i] = counts[0] + ... + counts[i - 1] for i < size, the number of counts. Returns the last sum, sums[size - 1].
  static Index RunningSum(const HostBuffer<Index>& counts, HostBuffer<Index>& sums) {
    Index sum = 0, last = 0;
    for (Index i = 0; i < counts.size(); ++i) {
      last = sums[i] = sum;
      sum += counts[i];
    }
    return last;
  }
};

}  // namespace vesta
