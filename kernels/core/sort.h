// Sorting and running sums, one call for all memory spaces: the host's here, a GPU's in device_sort.h. Results depend
// on the input alone.
#pragma once

#include <cstdint>

#include "kernels/core/radix_sort.h"

namespace vesta {

template <class Space>
struct Sorting;

template <>
struct Sorting<Host> {
  // Sorts the values by their keys, equal keys staying in their order. The keys hold anything afterwards.
  static void ByKey(HostBuffer<std::uint32_t>& keys, HostBuffer<std::uint32_t>& values) {
    HostBuffer<KeyValue> items, scratch;
    items.ResizeForOverwrite(keys.size());
    for (Index i = 0; i < keys.size(); ++i) items[i] = {keys[i], values[i]};
    RadixSort(items, scratch);
    for (Index i = 0; i < keys.size(); ++i) values[i] = items[i].value;
  }

  // sums[i] = counts[0] + ... + counts[i - 1]; as many as there are counts, of which the last is not summed. Returns
  // the last sum.
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
