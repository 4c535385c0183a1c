// SPDX-License-Identifier: Apache-2.0
// The structure of a block-sparse problem: the positions of all blocks in steps, residuals and stored Jacobians. It is
// computed once and used by every linearization.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/span.h"

namespace vesta {

// A residual block: its number of residuals, and the indices of its parameter blocks.
struct ResidualBlock {
  int num_residuals = 0;
  std::span<const int> parameters;
};

// A list of residual blocks, in few arrays because there may be millions of blocks. A removed block leaves a slot
// without residuals and parameter blocks. A later block with the same number of parameter blocks reuses the slot.
class ResidualBlockList {
 public:
  // Number of slots.
  std::size_t size() const { return slots_.size(); }
  std::size_t num_empty() const { return num_empty_; }
  // Number of parameter blocks, summed over all slots.
  std::size_t num_arguments() const { return parameters_.size(); }
  ResidualBlock operator[](std::size_t k) const {
    const Slot& slot = slots_[k];
    return {slot.num_residuals, {parameters_.data() + slot.first, static_cast<std::size_t>(slot.num_parameters)}};
  }
  void Reserve(std::size_t count) { slots_.reserve(count); }
  // Returns the slot of the block.
  std::size_t Add(const ResidualBlock& block);
  void Remove(std::size_t k);

 private:
  struct Slot {
    std::size_t first = 0;  // position in parameters_
    int num_parameters = 0;
    int num_residuals = 0;
  };
  std::vector<Slot> slots_;
  std::vector<int> parameters_;
  std::map<int, std::vector<std::size_t>> empty_;  // empty slots, by their number of parameter blocks
  std::size_t num_empty_ = 0;
};

// A parameter block as the caller added it.
struct ParameterBlock {
  Index ambient_offset = 0;  // position in x
  int ambient_size = 0;      // number of entries in x; 0 if the block was removed
  int tangent_size = 0;      // number of entries in a step; 0 if the block is constant
};

// The columns of a free parameter block (one that is not constant) in the Jacobian of one residual block.
struct BlockCell {
  int free = 0;      // index of the free block
  int argument = 0;  // position among the parameter blocks of the residual block
  int local = 0;     // first column within the residual block's dense Jacobian
  int size = 0;      // columns: the size of the free block
  Index offset = 0;  // position of the free block in a step
};

// A residual block with a free parameter block. Its Jacobian is a dense row-major matrix, num_residuals x width, at
// position value_offset of the values of a BlockJacobian.
struct BlockRow {
  Index residual_block = 0;   // index in the ResidualBlockList
  Index residual_offset = 0;  // position of its residuals
  Index value_offset = 0;
  int num_residuals = 0;
  int width = 0;  // sum of the sizes of its free blocks
  Index first_cell = 0;
  int num_cells = 0;
  int eliminated_cell = -1;  // index of the eliminated cell among the cells of this row, or -1
};

// A free parameter block: not constant, and used by a residual block. Free blocks are sorted: first the kept blocks,
// then the eliminated ones; within each of them by tangent size, then in the order in which they were added.
// Consecutive blocks of equal size form one BlockGroup.
struct FreeBlock {
  int parameter = 0;  // index of the parameter block
  int size = 0;       // tangent size
  Index offset = 0;   // position in a step
  int group = 0;
  Index index_in_group = 0;
};

// A residual block that depends on a given free block, and the position of the free block's columns.
struct BlockUse {
  Index row = 0;  // index in BlockStructure::rows
  int local = 0;  // first column within its dense Jacobian
};

class BlockStructure {
 public:
  // eliminate: search for free blocks that share no residual block with each other. They are eliminated, and put last
  // in a step, if they contain most of the unknowns. The search is greedy: it starts with the blocks in the fewest
  // residual blocks, like Ceres's independent-set orderings.
  BlockStructure(std::span<const ParameterBlock> parameters, const ResidualBlockList& residuals, bool eliminate);

  Index num_tangent() const { return num_tangent_; }
  // Number of tangent parameters that are not eliminated.
  Index num_kept() const { return num_kept_; }
  int num_kept_blocks() const { return num_kept_blocks_; }
  Index num_residuals() const { return num_residuals_; }
  // Number of stored entries of J.
  Index num_values() const { return num_values_; }
  const std::vector<FreeBlock>& free_blocks() const { return free_; }
  // The free block of a parameter block, or null.
  const FreeBlock* Find(int parameter) const {
    const int k = free_of_[static_cast<std::size_t>(parameter)];
    return k < 0 ? nullptr : &free_[static_cast<std::size_t>(k)];
  }
  // The residual blocks with a free parameter block, in the order in which they were added.
  const std::vector<BlockRow>& rows() const { return rows_; }
  // Indices of the other residual blocks, whose cost never changes.
  const std::vector<Index>& fixed_residual_blocks() const { return fixed_residual_blocks_; }
  std::span<const BlockCell> cells(const BlockRow& row) const {
    return std::span(cells_).subspan(static_cast<std::size_t>(row.first_cell), static_cast<std::size_t>(row.num_cells));
  }
  // Uses of a free block, in the order of the rows.
  std::span<const BlockUse> uses(int free) const {
    const auto k = static_cast<std::size_t>(free);
    return std::span(uses_).subspan(first_use_[k], first_use_[k + 1] - first_use_[k]);
  }
  // Groups of all free blocks, of the kept ones, and of the eliminated ones. The offsets in each list count from the
  // first parameter of its blocks.
  const std::vector<BlockGroup>& groups() const { return groups_; }
  const std::vector<BlockGroup>& kept_groups() const { return kept_groups_; }
  const std::vector<BlockGroup>& eliminated_groups() const { return eliminated_groups_; }

 private:
  void NumberFreeBlocks(std::span<const ParameterBlock> parameters, const std::vector<bool>& used,
                        const std::vector<bool>& eliminated);
  void PlaceRows(const ResidualBlockList& residuals, const std::vector<bool>& eliminated);
  void ListUses();

  Index num_tangent_ = 0, num_kept_ = 0, num_residuals_ = 0, num_values_ = 0;
  int num_kept_blocks_ = 0;
  std::vector<FreeBlock> free_;
  std::vector<int> free_of_;  // per parameter block: its index in free_, or -1
  std::vector<BlockRow> rows_;
  std::vector<Index> fixed_residual_blocks_;
  std::vector<BlockCell> cells_;
  std::vector<std::size_t> first_use_;
  std::vector<BlockUse> uses_;
  std::vector<BlockGroup> groups_, kept_groups_, eliminated_groups_;
};

// Returns a lower bound on the longest distance between two kept blocks, in hops. Two kept blocks are one hop apart if
// a residual block uses both, or if both share residual blocks with the same eliminated block. One iteration of
// conjugate gradients spreads information by one hop, so the distance predicts the number of iterations. The bound
// comes from two breadth-first searches through each connected component; it is exact for trees.
int LongestDistanceLowerBound(const BlockStructure& structure);

}  // namespace vesta
