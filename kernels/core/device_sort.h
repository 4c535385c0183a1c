// SPDX-License-Identifier: Apache-2.0
// Sorting and running sums in the memory of a GPU, by CUB. Results depend on the input alone.
#pragma once

#include <cstdint>

#include "kernels/core/device_buffer.h"
#include "kernels/core/sort.h"

namespace vesta::device {

// Sorts values along with keys by the lowest `bits` bits of the keys, equal keys staying in their order. The results
// lie in keys and values; the other two are of the same sizes and hold anything afterwards, as does temporary.
void SortPairs(DeviceBuffer<std::uint32_t>& keys, DeviceBuffer<std::uint32_t>& values,
               DeviceBuffer<std::uint32_t>& other_keys, DeviceBuffer<std::uint32_t>& other_values, Index count,
               int bits, DeviceBuffer<unsigned char>& temporary);

// sums[i] = counts[0] + ... + counts[i - 1] for i < size. May not overlap.
void RunningSum(const Index* counts, Index* sums, Index size, DeviceBuffer<unsigned char>& temporary);

}  // namespace vesta::device

namespace vesta {

// As those of the host. Both wait.
template <>
struct Sorting<Device> {
  static void ByKey(DeviceBuffer<std::uint32_t>& keys, DeviceBuffer<std::uint32_t>& values) {
    DeviceBuffer<std::uint32_t> other_keys, other_values;
    other_keys.ResizeForOverwrite(keys.size());
    other_values.ResizeForOverwrite(keys.size());
    DeviceBuffer<unsigned char> temporary;
    constexpr int kKeyBits = 32;
    device::SortPairs(keys, values, other_keys, other_values, keys.size(), kKeyBits, temporary);
  }
  static Index RunningSum(const DeviceBuffer<Index>& counts, DeviceBuffer<Index>& sums) {
    DeviceBuffer<unsigned char> temporary;
    device::RunningSum(counts.data(), sums.data(), counts.size(), temporary);
    Index last = 0;
    device::CopyToHost(&last, sums.data() + counts.size() - 1, sizeof(last));
    return last;
  }
};

}  // namespace vesta
