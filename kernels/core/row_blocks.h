// SPDX-License-Identifier: Apache-2.0
// Products with a Jacobian J that stores one dense block per residual block, all of the same shape. GPU solvers use
// them for problems that store their Jacobian. Each step is a functor, called for all indices in any order.
#pragma once

#include <algorithm>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/divisor.h"
#include "kernels/core/span.h"

namespace vesta {

// Dense blocks of `residuals` rows and `parameters` columns. Column c of block b belongs to the parameter index[c *
// blocks + b]. Row k of block b is row k * blocks + b of J, with entries jacobian[(k * parameters + c) * blocks + b].
template <class S>
struct RowBlocks {
  Index blocks = 0;
  int residuals = 0, parameters = 0;
  const Index* index = nullptr;
  const S* jacobian = nullptr;

  VESTA_HD S At(int k, int c, Index b) const { return jacobian[(k * parameters + c) * blocks + b]; }
};

// The transpose: for each parameter, the list of its columns in the blocks. Column c of block b is listed as c * blocks
// + b. The list of parameter p is entries[first_entry[p]] .. entries[first_entry[p + 1] - 1], ascending in b.
//
// Each list is split into segments of at most kSegmentEntries entries. Several threads can then share the work of a
// long list. Segment s has the entries segments[s] .. segment_end[s] - 1. Parameter p has the segments first_segment[p]
// .. first_segment[p + 1] - 1.
struct RowBlocksTranspose {
  const Index *entries, *first_entry, *segments, *segment_end, *first_segment;
};
inline constexpr Index kSegmentEntries = 32;

// For block b: its rows of u = J v.
template <class S>
struct MultiplyRows {
  RowBlocks<S> rows;
  const S* v;
  S* u;
  VESTA_HD void operator()(Index b) const {
    for (int k = 0; k < rows.residuals; ++k) {
      S sum(0);
      for (int c = 0; c < rows.parameters; ++c) sum += rows.At(k, c, b) * v[rows.index[c * rows.blocks + b]];
      u[k * rows.blocks + b] = sum;
    }
  }
};

// For segment s: partial[s] = the segment's part of J^T u, or of diag(J^T J) if u is null.
template <class S>
struct SumSegment {
  RowBlocks<S> rows;
  RowBlocksTranspose transpose;
  const S* u;
  S* partial;
  Divisor by_blocks{rows.blocks};
  VESTA_HD void operator()(Index s) const {
    S sum(0);
    for (Index e = transpose.segments[s]; e < transpose.segment_end[s]; ++e) {
      const Division entry = by_blocks.Divide(transpose.entries[e]);
      const Index b = entry.remainder;
      const int c = static_cast<int>(entry.quotient);
      for (int k = 0; k < rows.residuals; ++k) {
        const S value = rows.At(k, c, b);
        sum += value * (u != nullptr ? u[k * rows.blocks + b] : value);
      }
    }
    partial[s] = sum;
  }
};

// For parameter p: sums[p] = the sum of partial[s] over its segments s.
template <class S>
struct SumSegments {
  RowBlocksTranspose transpose;
  const S* partial;
  S* sums;
  VESTA_HD void operator()(Index p) const {
    S sum(0);
    for (Index s = transpose.first_segment[p]; s < transpose.first_segment[p + 1]; ++s) sum += partial[s];
    sums[p] = sum;
  }
};

// Computes values[k * group.count + g]: entry k of the packed lower triangle of diagonal block g of J^T J. If a
// residual block uses any parameter of a diagonal block, it must use all, in adjacent columns and in order.
template <class S>
struct GramOfRows {
  static constexpr int kMinBlocks = 1;
  RowBlocks<S> rows;
  RowBlocksTranspose transpose;
  BlockGroup group;
  S* values;
  Divisor by_blocks{rows.blocks}, by_count{group.count};
  VESTA_HD void operator()(Index i) const {
    const Division place = by_count.Divide(i);
    int row = 0;
    while (PackedLower(row + 1, 0) <= place.quotient) ++row;
    const int back = row - static_cast<int>(place.quotient - PackedLower(row, 0));
    const Index p = group.Parameter(place.remainder, row);
    S sum(0);
    for (Index e = transpose.first_entry[p]; e < transpose.first_entry[p + 1]; ++e) {
      const Division entry = by_blocks.Divide(transpose.entries[e]);
      const Index b = entry.remainder;
      const int c = static_cast<int>(entry.quotient);
      for (int k = 0; k < rows.residuals; ++k) sum += rows.At(k, c, b) * rows.At(k, c - back, b);
    }
    values[i] = sum;
  }
};

// Builds a RowBlocksTranspose on the host.
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

namespace vesta::device {

// Launch the steps above on a GPU, without waiting. All pointers are to device memory.
template <class S>
void ApplyRows(const RowBlocks<S>& rows, const S* v, S* u);
// If u is null, computes diag(J^T J). partial: one value per segment.
template <class S>
void ApplyRowsTransposed(const RowBlocks<S>& rows, const RowBlocksTranspose& transpose, Index segments,
                         Index parameters, const S* u, S* partial, S* g);
template <class S>
void GramBlocks(const RowBlocks<S>& rows, const RowBlocksTranspose& transpose, const BlockGroup& group, S* values);

}  // namespace vesta::device
