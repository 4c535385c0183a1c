// Sorting and running sums in the memory of a GPU, by CUB. Results depend on the input alone.
#pragma once

#include <cstdint>

#include "kernels/core/device_buffer.h"

namespace vesta::device {

// Sorts values along with keys by the lowest `bits` bits of the keys, equal keys staying in their order. The results
// lie in keys and values; the other two are of the same sizes and hold anything afterwards, as does temporary.
void SortPairs(DeviceBuffer<std::uint32_t>& keys, DeviceBuffer<std::uint32_t>& values,
               DeviceBuffer<std::uint32_t>& other_keys, DeviceBuffer<std::uint32_t>& other_values, Index count,
               int bits, DeviceBuffer<unsigned char>& temporary);

// sums[i] = counts[0] + ... + counts[i - 1] for i < size. May not overlap.
void RunningSum(const Index* counts, Index* sums, Index size, DeviceBuffer<unsigned char>& temporary);

}  // namespace vesta::device
