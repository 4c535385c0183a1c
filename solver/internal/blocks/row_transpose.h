// SPDX-License-Identifier: Apache-2.0
// The columns of small dense row blocks by parameter (kernels/core/row_blocks.h), made on the host.
#pragma once

#include <algorithm>
#include <vector>

#include "kernels/core/row_blocks.h"

namespace vesta {

struct HostRowTranspose {
  std::vector<Index> entries, first_entry, segments, segment_end, first_segment;

  // index: [parameters_per_block * blocks], as in RowBlocks.
  HostRowTranspose(Index num_parameters, const std::vector<Index>& index, Index blocks)
      : entries(index.size()), first_entry(static_cast<std::size_t>(num_parameters) + 1, 0) {
    for (const Index p : index) ++first_entry[static_cast<std::size_t>(p) + 1];
    for (std::size_t p = 1; p < first_entry.size(); ++p) first_entry[p] += first_entry[p - 1];
    std::vector<Index> next(first_entry.begin(), first_entry.end() - 1);
    const Index columns = blocks > 0 ? static_cast<Index>(index.size()) / blocks : 0;
    for (Index b = 0; b < blocks; ++b) {
      for (Index c = 0; c < columns; ++c) {
        const Index entry = c * blocks + b;
        const auto p = static_cast<std::size_t>(index[static_cast<std::size_t>(entry)]);
        entries[static_cast<std::size_t>(next[p]++)] = entry;
      }
    }
    first_segment.push_back(0);
    for (std::size_t p = 0; p + 1 < first_entry.size(); ++p) {
      for (Index e = first_entry[p]; e < first_entry[p + 1]; e += kSegmentEntries) {
        segments.push_back(e);
        segment_end.push_back(std::min(e + kSegmentEntries, first_entry[p + 1]));
      }
      first_segment.push_back(static_cast<Index>(segments.size()));
    }
  }
  RowBlocksTranspose view() const {
    return {entries.data(), first_entry.data(), segments.data(), segment_end.data(), first_segment.data()};
  }
};

}  // namespace vesta
