// SPDX-License-Identifier: Apache-2.0
// Loops over terms. A term is the block-sparse gradient of one view, or the sum of several (sum_of_views.h). It stores
// a block of 16 neighbouring Gaussians only if one of its views sees a Gaussian of the block. All pointers of a loop
// are in one memory space.
#pragma once

#include <cstdint>

#include "kernels/core/divisor.h"
#include "kernels/core/for_each.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "splatting/density/density_steps.h"

namespace vesta::gs::term {

// Gaussians per block. Neighbours in memory are mostly visible in the same views.
inline constexpr Index kLanes = 16;
// The rows of a block, with one number per Gaussian. Row kPullRow: sum of the pulls over the views
// (density/density_steps.h). Then the gradient of each attribute.
inline constexpr int kPullRow = 0, kFirstAttribute = 1;

// Common to all terms of an iteration.
struct Layout {
  splat::ModelLayout model;
  int attributes;  // number of attributes per Gaussian at the SH degree of this iteration

  VESTA_HD Index Blocks() const { return (model.count + kLanes - 1) / kLanes; }
  // Rows of a block. The first Gaussian of a block has the highest SH degree: models are sorted by descending degree.
  VESTA_HD Index RowsOf(Index block) const {
    int degree = model.sh_degree;
    while (block * kLanes >= model.WithBand(degree)) --degree;
    const int own = splat::NumAttributes(degree);
    return kFirstAttribute + (own < attributes ? own : attributes);
  }
  // Maximum of RowsOf.
  VESTA_HD Index MostRows() const { return kFirstAttribute + attributes; }
};

// block: block numbers, ascending; begin: first row of each block. Row r has the numbers rows[kLanes * r] to
// rows[kLanes * r + kLanes - 1].
struct Arrays {
  const std::uint32_t *block, *begin;
  const float* rows;
};

// Packs two counts into one integer: one block in the bits above kRowBits, and its number of rows in the lower bits. A
// running sum of these integers counts blocks and rows at once. The Unpack functions return the two counts of a sum.
inline constexpr int kRowBits = 40;
VESTA_HD constexpr Index PackCounts(Index rows) { return (Index{1} << kRowBits) + rows; }
VESTA_HD constexpr Index UnpackBlocks(Index sum) { return sum >> kRowBits; }
VESTA_HD constexpr Index UnpackRows(Index sum) { return sum & ((Index{1} << kRowBits) - 1); }

// counts[b] = PackCounts(rows of block b) if a Gaussian of block b is visible, else 0. Also called for b =
// layout.Blocks(), one past the last block: it stores 0 there, so that the last exclusive running sum is the total.
struct CountVisible {
  Layout layout;
  const std::int32_t* rank_of;  // depth rank by Gaussian; -1: not visible
  Index* counts;

  VESTA_HD void operator()(Index block) const {
    counts[block] = 0;
    for (Index i = block * kLanes; i < (block + 1) * kLanes && i < layout.model.count; ++i) {
      if (rank_of[i] >= 0) counts[block] = PackCounts(layout.RowsOf(block));
    }
  }
};

// For block k of a term: places[block[k]] = k + 1.
struct PlaceBlocks {
  const std::uint32_t* block;
  std::uint32_t* places;
  VESTA_HD void operator()(Index k) const { places[block[k]] = static_cast<std::uint32_t>(k + 1); }
};

// counts[b] = PackCounts(rows of block b) if at least one of two terms has block b, else 0. Also called for b =
// layout.Blocks(), where it stores 0, as CountVisible does.
struct CountEither {
  Layout layout;
  const std::uint32_t *left, *right;  // by block, from PlaceBlocks; 0: not in the term
  Index* counts;

  VESTA_HD void operator()(Index block) const {
    const bool is_there = block < layout.Blocks() && (left[block] > 0 || right[block] > 0);
    counts[block] = is_there ? PackCounts(layout.RowsOf(block)) : 0;
  }
};

// Writes the arrays `block` and `begin` of a new term (Arrays), with an entry for each block b whose count is not 0.
// counts: from CountVisible or CountEither; sums: their exclusive running sums, which give the position of the entry
// and the first row of the block.
struct ListBlocks {
  const Index *counts, *sums;
  std::uint32_t *block, *begin;

  VESTA_HD void operator()(Index b) const {
    if (counts[b] == 0) return;
    const Index k = UnpackBlocks(sums[b]);
    block[k] = static_cast<std::uint32_t>(b);
    begin[k] = static_cast<std::uint32_t>(UnpackRows(sums[b]));
  }
};

// Index of a row in a parallel loop: row r of block k has the index k * layout.MostRows() + r. Indices of missing rows
// are skipped.
struct RowOfBlock {
  Layout layout;
  const std::uint32_t* block;
  Divisor by_rows{layout.MostRows()};

  // Calls body(k, block[k], r) if the row exists.
  template <class Body>
  VESTA_HD void Visit(Index index, const Body& body) const {
    const auto [k, row] = by_rows.Divide(index);
    const Index number = block[k];
    if (row < layout.RowsOf(number)) body(k, number, row);
  }
  // Rows of attributes only: calls body(k, r, first, length). The row corresponds to the elements [first, first +
  // length) of an array with the layout of the model.
  template <class Body>
  VESTA_HD void VisitAttribute(Index index, const Body& body) const {
    Visit(index, [&](Index k, Index number, Index row) {
      if (row < kFirstAttribute) return;
      const int attribute = static_cast<int>(row) - kFirstAttribute;
      const Index first = number * kLanes, left = layout.model.Rows(attribute) - first;
      body(k, row, layout.model.Offset(attribute) + first, left < kLanes ? left : kLanes);
    });
  }
};

// Moves a row of gradients from an array with the layout of the model to a term. The array's elements become zero.
struct ExtractRow {
  RowOfBlock of;
  const std::uint32_t* begin;
  float *gradient, *rows;

  VESTA_HD void operator()(Index index) const {
    of.VisitAttribute(index, [&](Index k, Index row, Index first, Index length) {
      float *from = gradient + first, *to = rows + (begin[k] + row) * kLanes;
      for (Index lane = 0; lane < kLanes; ++lane) {
        to[lane] = lane < length ? from[lane] : 0.0f;
        if (lane < length) from[lane] = 0;
      }
    });
  }
};

// Fills the row kPullRow of block k for one view; with zeros unless needs_pull.
struct ObserveBlock {
  density::PullView view;
  bool needs_pull;
  Index count;
  const std::uint32_t *block, *begin;
  float* rows;

  VESTA_HD void operator()(Index k) const {
    float* pull = rows + (begin[k] + kPullRow) * kLanes;
    for (Index lane = 0; lane < kLanes; ++lane) {
      const Index i = block[k] * kLanes + lane;
      pull[lane] = needs_pull && i < count && view.rank_of[i] >= 0 ? view.Of(i) : 0.0f;
    }
  }
};

// A row of sum = left + right. A block that one term lacks is copied from the other.
struct AddRow {
  RowOfBlock of;
  const std::uint32_t *begin, *left_places, *right_places;
  Arrays left, right;
  float* sum;

  VESTA_HD void operator()(Index index) const {
    of.Visit(index, [&](Index k, Index number, Index row) {
      const std::uint32_t l = left_places[number], r = right_places[number];
      const float* a = l > 0 ? left.rows + (left.begin[l - 1] + row) * kLanes : nullptr;
      const float* b = r > 0 ? right.rows + (right.begin[r - 1] + row) * kLanes : nullptr;
      float* to = sum + (begin[k] + row) * kLanes;
      for (Index lane = 0; lane < kLanes; ++lane) {
        to[lane] = !b ? a[lane] : !a ? b[lane] : a[lane] + b[lane];
      }
    });
  }
};

// Copies a row of an attribute to an array with the layout of the model.
struct CopyRow {
  RowOfBlock of;
  Arrays term;
  float* values;

  VESTA_HD void operator()(Index index) const {
    of.VisitAttribute(index, [&](Index k, Index row, Index first, Index length) {
      const float* from = term.rows + (term.begin[k] + row) * kLanes;
      for (Index lane = 0; lane < length; ++lane) values[first + lane] = from[lane];
    });
  }
};

// Adds the pulls of block k to `pull`, one number per Gaussian.
struct AddPull {
  Arrays term;
  Index count;
  float* pull;

  VESTA_HD void operator()(Index k) const {
    const float* row = term.rows + (term.begin[k] + kPullRow) * kLanes;
    for (Index lane = 0, i = term.block[k] * kLanes; lane < kLanes && i < count; ++lane, ++i) pull[i] += row[lane];
  }
};

}  // namespace vesta::gs::term
