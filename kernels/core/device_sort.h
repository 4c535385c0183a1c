// SPDX-License-Identifier: Apache-2.0
// Sorting and running sums on a GPU with CUB. The results depend only on the input.
#pragma once

#include <cstdint>

#include "kernels/core/device_buffer.h"
#include "kernels/core/sort.h"

namespace vesta::device {

// Stable sort of (key, value) pairs by the lowest `bits` bits of the keys, in place. other_keys and other_values, of
// the same sizes, and `temporary` are scratch memory.
void SortPairs(DeviceBuffer<std::uint32_t>& keys, DeviceBuffer<std::uint32_t>& values,
               DeviceBuffer<std::uint32_t>& other_keys, DeviceBuffer<std::uint32_t>& other_values, Index count,
               int bits, DeviceBuffer<unsigned char>& temporary);

// sums[0] = 0; sums[i] = counts[0] + ... + counts[i - 1] for 0 < i < size. The arrays must not overlap.
void RunningSum(const Index* counts, Index* sums, Index size, DeviceBuffer<unsigned char>& temporary);

}  // namespace vesta::device

namespace vesta {

// Same interface as Sorting<Host>. RunningSum waits for its result and needs at least one count; ByKey does not wait.
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
