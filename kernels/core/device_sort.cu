// SPDX-License-Identifier: Apache-2.0
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

#include "kernels/core/cuda_runtime.cuh"
#include "kernels/core/device_kernels.h"
#include "kernels/core/device_sort.h"

namespace vesta::device {
namespace {

// Calls a CUB function twice: for the size of its scratch memory, and for the work.
template <class Call>
void RunCub(const Call& call, DeviceBuffer<unsigned char>& temporary, const char* name) {
  std::size_t bytes = 0;
  CheckCuda(call(nullptr, bytes), name);
  if (static_cast<std::size_t>(temporary.size()) < bytes) temporary.ResizeForOverwrite(static_cast<Index>(bytes));
  ++CountedHostWork().launches;
  CheckCuda(call(temporary.data(), bytes), name);
}

}  // namespace

void SortPairs(DeviceBuffer<std::uint32_t>& keys, DeviceBuffer<std::uint32_t>& values,
               DeviceBuffer<std::uint32_t>& other_keys, DeviceBuffer<std::uint32_t>& other_values, Index count,
               int bits, DeviceBuffer<unsigned char>& temporary) {
  if (count == 0) return;
  cub::DoubleBuffer<std::uint32_t> key_buffers(keys.data(), other_keys.data());
  cub::DoubleBuffer<std::uint32_t> value_buffers(values.data(), other_values.data());
  RunCub(
      [&](void* memory, std::size_t& bytes) {
        return cub::DeviceRadixSort::SortPairs(memory, bytes, key_buffers, value_buffers, count, 0, bits, Stream());
      },
      temporary, "radix sort");
  if (key_buffers.selector == 1) std::swap(keys, other_keys);
  if (value_buffers.selector == 1) std::swap(values, other_values);
}

void RunningSum(const Index* counts, Index* sums, Index size, DeviceBuffer<unsigned char>& temporary) {
  if (size == 0) return;
  RunCub([&](void* memory,
             std::size_t& bytes) { return cub::DeviceScan::ExclusiveSum(memory, bytes, counts, sums, size, Stream()); },
         temporary, "running sum");
}

}  // namespace vesta::device
