// SPDX-License-Identifier: Apache-2.0
// Members of BlockDiagonal (block_diagonal.h) that all memory spaces share.
#pragma once

#include <algorithm>
#include <utility>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/check.h"

namespace vesta {
namespace block_internal {

// Lowest and highest parameter of a group.
inline std::pair<Index, Index> Range(const BlockGroup& group) {
  Index lowest = group.offset, highest = group.offset;
  for (const Index reach : {(group.size - 1) * group.component_stride, (group.count - 1) * group.block_stride}) {
    lowest += std::min<Index>(reach, 0);
    highest += std::max<Index>(reach, 0);
  }
  return {lowest, highest};
}

}  // namespace block_internal

template <class B>
BlockDiagonal<B>::BlockDiagonal(Index num_parameters, std::vector<BlockGroup> groups)
    : num_parameters_(num_parameters), groups_(std::move(groups)) {
  Index covered = 0, values = 0;
  for (const BlockGroup& group : groups_) {
    VESTA_CHECK(group.size >= 1 && group.count >= 0, "block group of {} blocks of size {}", group.count, group.size);
    if (group.count > 0) {
      const auto [lowest, highest] = block_internal::Range(group);
      VESTA_CHECK(lowest >= 0 && highest < num_parameters, "a block group covers parameters {} to {} of {}", lowest,
                  highest, num_parameters);
    }
    first_value_.push_back(values);
    covered += group.count * group.size;
    values += group.NumValues();
  }
  VESTA_CHECK(covered == num_parameters, "block groups cover {} of {} parameters", covered, num_parameters);
  values_.Resize(values);
}

template <class B>
typename B::VectorView BlockDiagonal<B>::values(int group) {
  const auto g = static_cast<std::size_t>(group);
  return all_values().subspan(first_value_[g], groups_[g].NumValues());
}

template <class B>
typename B::ConstVectorView BlockDiagonal<B>::values(int group) const {
  const auto g = static_cast<std::size_t>(group);
  return values_.view().subspan(first_value_[g], groups_[g].NumValues());
}

template <class B>
typename B::VectorView BlockDiagonal<B>::all_values() {
  return values_.view();
}

template <class B>
void BlockDiagonal<B>::Add(double scale, const BlockDiagonal& other) {
  B().Axpby(scale, other.values_.view(), 1.0, values_.view());
}

}  // namespace vesta
