// SPDX-License-Identifier: Apache-2.0
// Stores which parameters each residual block reads, and which residual blocks form a batch. This part of
// ResidualBlocks (solver/residual_blocks.h) does not depend on the functor type.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "kernels/core/span.h"
#include "solver/loss.h"

namespace vesta {

// How residual blocks are assigned to batches; see ResidualBlocksOptions.
enum class BatchSplit { kStrided, kContiguous };

namespace residual_blocks_internal {

// Column `column` of the Jacobian of residual block `block` of a batch.
struct Entry {
  Index block;
  int column;
};

// Lists, for each parameter, its columns in the Jacobians of the residual blocks, in the order of the blocks. Products
// with J^T sum over these columns in this order.
class Transpose {
 public:
  Transpose() = default;
  // index: parameters_per_block parameters of each residual block of the problem. blocks: the residual blocks of the
  // batch.
  Transpose(Index num_parameters, int parameters_per_block, std::span<const Index> index,
            std::span<const Index> blocks);
  std::span<const Entry> of(Index parameter) const {
    const auto k = static_cast<std::size_t>(parameter);
    return std::span(entries_).subspan(first_[k], first_[k + 1] - first_[k]);
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<Entry> entries_;
};

class Layout {
 public:
  // index: as in ResidualBlocks. Throws Error if its size is wrong, or if a parameter is out of range or repeated. The
  // transposes of batches with at most max_scattered blocks stay empty.
  Layout(Index num_parameters, Index num_blocks, int parameters_per_block, std::vector<Index> index, int num_batches,
         BatchSplit split, Index max_scattered = -1);

  Index num_parameters() const { return num_parameters_; }
  // The parameters that a residual block reads.
  const Index* parameters(Index block) const { return index_.data() + block * parameters_per_block_; }
  // The residual blocks of a batch, and the columns of each parameter in them.
  const std::vector<Index>& blocks(int batch) const { return batches_[static_cast<std::size_t>(batch)]; }
  const Transpose& transpose(int batch) const { return transposes_[static_cast<std::size_t>(batch)]; }

  // Describes the first value of a residual block that is not finite at x; empty if all are finite. loss: null for
  // none. defined: false if the functor returned false. jacobian: column by column; empty if it need not be checked. S
  // is float or double.
  template <class S>
  std::string DescribeNonFinite(Index block, std::span<const S> x, const Loss* loss, bool defined,
                                std::span<const S> residuals, std::span<const S> jacobian) const;

 private:
  // The checks of the constructor.
  void CheckIndex(Index num_blocks) const;
  // Throws Error if the block reads a parameter twice.
  void CheckDifferent(Index block) const;

  Index num_parameters_;
  int parameters_per_block_;
  std::vector<Index> index_;
  std::vector<std::vector<Index>> batches_;
  std::vector<Transpose> transposes_;
};

template <class S>
double SquaredNorm(const S* f, std::size_t size) {
  double s = 0;
  for (std::size_t i = 0; i < size; ++i) s += static_cast<double>(f[i]) * static_cast<double>(f[i]);
  return s;
}

// Name of a residual, for error messages.
std::string NameOf(Index block, int residual);

}  // namespace residual_blocks_internal
}  // namespace vesta
