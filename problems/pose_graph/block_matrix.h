// Symmetric sparse matrices of square blocks, one row of blocks for each pose that moves.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "kernels/core/buffer.h"

namespace vesta::pose_graph {

// Which blocks off the diagonal are there. Those on it always are.
class BlockPattern {
 public:
  // An unordered pair of different rows; repeats are the same block.
  struct Pair {
    Index a, b;
  };
  // A row that has a block with another one, and that block's number.
  struct Neighbor {
    Index row, block;
  };

  // Each of pairs has 0 <= a, b < num_rows.
  BlockPattern(Index num_rows, std::span<const Pair> pairs);

  Index num_rows() const { return static_cast<Index>(first_.size()) - 1; }
  // Number of blocks under the diagonal.
  Index num_blocks() const { return static_cast<Index>(neighbors_.size()) / 2; }
  // In ascending order of rows.
  std::span<const Neighbor> neighbors(Index row) const {
    const auto r = static_cast<std::size_t>(row);
    return std::span(neighbors_).subspan(first_[r], first_[r + 1] - first_[r]);
  }
  // The block of each of the constructor's pairs.
  const std::vector<Index>& block_of_pair() const { return block_of_pair_; }

 private:
  std::vector<std::size_t> first_;
  std::vector<Neighbor> neighbors_;
  std::vector<Index> block_of_pair_;
};

// Values on a pattern; blocks are row-major.
class BlockMatrix {
 public:
  // block_size is 3 or 6. All zero.
  BlockMatrix(std::shared_ptr<const BlockPattern> pattern, int block_size);

  const BlockPattern& pattern() const { return *pattern_; }
  int block_size() const { return block_size_; }
  // Scalar rows.
  Index size() const { return pattern_->num_rows() * block_size_; }

  double* diagonal(Index row) { return diagonal_.data() + row * block_size_ * block_size_; }
  const double* diagonal(Index row) const { return diagonal_.data() + row * block_size_ * block_size_; }
  // The block of two rows, stored as that of the larger one's rows and the smaller one's columns.
  double* block(Index k) { return blocks_.data() + k * block_size_ * block_size_; }
  const double* block(Index k) const { return blocks_.data() + k * block_size_ * block_size_; }

  // y = this x. Sums go over the columns in ascending order.
  void Apply(HostSpan<const double> x, HostSpan<double> y) const;

 private:
  template <int D>
  void ApplyBlocks(const double* x, double* y) const;

  std::shared_ptr<const BlockPattern> pattern_;
  int block_size_;
  HostBuffer<double> diagonal_, blocks_;
};

}  // namespace vesta::pose_graph
