// Stable sort of 32-bit keys.
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

// Sorts items by key, equal keys staying in their order; scratch is resized as needed. Least-significant-digit radix
// sort, three passes of 11 bits; a pass whose digit is constant is skipped.
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

}  // namespace vesta
