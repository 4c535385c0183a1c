// SPDX-License-Identifier: Apache-2.0
// Defines which parameters each residual block reads and which residual blocks form a batch. ResidualBlocks uses it; it
// does not depend on the functors.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "kernels/core/span.h"
#include "solver/loss.h"

namespace vesta {

// How residual blocks are assigned to batches.
enum class BatchSplit { kStrided, kContiguous };

namespace residual_blocks_internal {

// Position of one parameter in the Jacobian: column `column` of residual block `block`.
struct Entry {
  Index block;
  int column;
};

// Lists each parameter's columns in the Jacobian, in the order of the residual blocks. Products with J^T sum over them
// in this fixed order.
class Transpose {
 public:
  // index: parameters_per_block parameters per residual block of the problem. blocks: the residual blocks to list.
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
  // index: as in ResidualBlocks. Throws Error if its size is wrong, or if a parameter is out of range or repeated.
  Layout(Index num_parameters, Index num_blocks, int parameters_per_block, std::vector<Index> index, int num_batches,
         BatchSplit split);

  Index num_parameters() const { return num_parameters_; }
  // The parameters that a residual block reads.
  const Index* parameters(Index block) const { return index_.data() + block * parameters_per_block_; }
  // The residual blocks of a batch, and their columns by parameter.
  const std::vector<Index>& blocks(int batch) const { return batches_[static_cast<std::size_t>(batch)]; }
  const Transpose& transpose(int batch) const { return transposes_[static_cast<std::size_t>(batch)]; }

  // Describes the first value of a residual block that is not finite at x; empty if all are finite. defined: false if
  // the functor returned false. loss: null for none. jacobian: column by column; empty to skip it. For float and
  // double.
  template <class S>
  std::string DescribeNonFinite(Index block, std::span<const S> x, const Loss* loss, bool defined,
                                std::span<const S> residuals, std::span<const S> jacobian) const;

 private:
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

std::string NameOf(Index block, int residual);

}  // namespace residual_blocks_internal
}  // namespace vesta
