// SPDX-License-Identifier: Apache-2.0
// The structure of a block-sparse problem: where everything of it lies, worked out once and used by every
// linearization, and how far apart its blocks are.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/span.h"

namespace vesta {

// A residual block: how many residuals, of which parameter blocks.
struct ResidualBlock {
  int num_residuals = 0;
  std::span<const int> parameters;
};

// Thousands to millions of them, in three arrays.
class ResidualBlockList {
 public:
  std::size_t size() const { return num_residuals_.size(); }
  // Parameters of all residual blocks together.
  std::size_t num_arguments() const { return parameters_.size(); }
  ResidualBlock operator[](std::size_t k) const {
    return {num_residuals_[k], std::span(parameters_).subspan(first_[k], first_[k + 1] - first_[k])};
  }
  void Reserve(std::size_t count) {
    num_residuals_.reserve(count);
    first_.reserve(count + 1);
  }
  void Add(const ResidualBlock& block) {
    parameters_.insert(parameters_.end(), block.parameters.begin(), block.parameters.end());
    first_.push_back(parameters_.size());
    num_residuals_.push_back(block.num_residuals);
  }

 private:
  std::vector<int> num_residuals_;
  std::vector<std::size_t> first_{0};  // of each block's parameters; the end of the last
  std::vector<int> parameters_;
};

// A parameter block as the caller gave it.
struct ParameterBlock {
  Index ambient_offset = 0;  // in x
  int ambient_size = 0;
  int tangent_size = 0;  // 0: constant
};

// A free parameter block's columns within one residual block's Jacobian.
struct BlockCell {
  int free = 0;      // which free block
  int argument = 0;  // which argument of the residual block
  int local = 0;     // first column within the residual block's dense Jacobian
  int size = 0;      // columns: the free block's
  Index offset = 0;  // the free block's, in the step
};

// One residual block: a dense Jacobian of num_residuals x width, row after row, at values[value_offset].
struct BlockRow {
  Index residual_offset = 0;
  Index value_offset = 0;
  int num_residuals = 0;
  int width = 0;
  Index first_cell = 0;
  int num_cells = 0;
  int eliminated_cell = -1;  // among its cells; -1: none
};

// A free parameter block. Free blocks are numbered kept before eliminated, then by tangent size, then by order of being
// added; so each run of equal size is one BlockGroup.
struct FreeBlock {
  int parameter = 0;  // which parameter block
  int size = 0;       // tangent
  Index offset = 0;   // in the step
  int group = 0;
  Index index_in_group = 0;
};

// One place a free block is used: a column range of a row.
struct BlockUse {
  Index row = 0;
  int local = 0;
};

class BlockStructure {
 public:
  // eliminate: find a group of blocks no two of which share a residual (greedily, the least used first, after the
  // independent sets of Ceres's orderings) and put it last, where it is most of the step.
  BlockStructure(std::span<const ParameterBlock> parameters, const ResidualBlockList& residuals, bool eliminate);

  Index num_tangent() const { return num_tangent_; }
  // Tangent parameters that are not eliminated; num_tangent() when nothing is.
  Index num_kept() const { return num_kept_; }
  int num_kept_blocks() const { return num_kept_blocks_; }
  Index num_residuals() const { return num_residuals_; }
  Index num_values() const { return num_values_; }
  const std::vector<FreeBlock>& free_blocks() const { return free_; }
  const std::vector<BlockRow>& rows() const { return rows_; }
  std::span<const BlockCell> cells(const BlockRow& row) const {
    return std::span(cells_).subspan(static_cast<std::size_t>(row.first_cell), static_cast<std::size_t>(row.num_cells));
  }
  // Uses of a free block, in the order of the rows.
  std::span<const BlockUse> uses(int free) const {
    const auto k = static_cast<std::size_t>(free);
    return std::span(uses_).subspan(first_use_[k], first_use_[k + 1] - first_use_[k]);
  }
  // Over all free blocks, and over the kept and the eliminated ones alone (offsets from 0 in each).
  const std::vector<BlockGroup>& groups() const { return groups_; }
  const std::vector<BlockGroup>& kept_groups() const { return kept_groups_; }
  const std::vector<BlockGroup>& eliminated_groups() const { return eliminated_groups_; }

 private:
  void NumberFreeBlocks(std::span<const ParameterBlock> parameters, const std::vector<bool>& eliminated,
                        std::vector<int>& free_of);
  void LayRows(const ResidualBlockList& residuals, const std::vector<bool>& eliminated,
               const std::vector<int>& free_of);
  void ListUses();

  Index num_tangent_ = 0, num_kept_ = 0, num_residuals_ = 0, num_values_ = 0;
  int num_kept_blocks_ = 0;
  std::vector<FreeBlock> free_;
  std::vector<BlockRow> rows_;
  std::vector<BlockCell> cells_;
  std::vector<std::size_t> first_use_;
  std::vector<BlockUse> uses_;
  std::vector<BlockGroup> groups_, kept_groups_, eliminated_groups_;
};

// The longest way between two kept blocks, in hops: from a block to those that it shares a residual block with, or an
// eliminated block. An error crosses one hop in an iteration of conjugate gradients on what is kept. Found by two
// searches through each part that hangs together, so it is a lower bound (exact for trees), at the cost of a pass over
// the cells.
int LongestDistance(const BlockStructure& structure);

}  // namespace vesta
