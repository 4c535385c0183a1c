// SPDX-License-Identifier: Apache-2.0
// Sparse symmetric matrices of small dense blocks, and H = J^T J summed up as one. Each row of blocks has a size of its
// own, that of its column too.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "kernels/core/buffer.h"
#include "solver/internal/blocks/block_jacobian.h"

namespace vesta {

// An object whose memory goes from one owner to the next: remembers the last T that it gave out, and gives it out again
// once nobody else holds it.
template <class T>
class Kept {
 public:
  template <class Make>
  std::shared_ptr<T> Get(const Make& make) {
    if (!last_ || last_.use_count() > 1) last_ = make();
    return last_;
  }

 private:
  std::shared_ptr<T> last_;
};

// The sizes of the rows of blocks, and which blocks off the diagonal are there. Those on it always are.
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

  // sizes: scalars of each row of blocks, >= 1. Each of pairs has 0 <= a, b < the number of rows.
  BlockPattern(std::span<const int> sizes, std::span<const Pair> pairs);

  Index num_rows() const { return static_cast<Index>(sizes_.size()); }
  // Number of blocks under the diagonal.
  Index num_blocks() const { return static_cast<Index>(neighbors_.size()) / 2; }
  int size(Index row) const { return sizes_[At(row)]; }
  // The first scalar of a row; for num_rows(), the number of scalars.
  Index offset(Index row) const { return offsets_[At(row)]; }
  Index num_scalars() const { return offsets_.back(); }
  // The size of all rows, or 0 where they differ.
  int uniform_size() const { return uniform_size_; }
  // In ascending order of rows.
  std::span<const Neighbor> neighbors(Index row) const {
    return std::span(neighbors_).subspan(first_[At(row)], first_[At(row) + 1] - first_[At(row)]);
  }
  // The block of each of the constructor's pairs.
  const std::vector<Index>& block_of_pair() const { return block_of_pair_; }
  // Where the values of a diagonal block, or of another one, begin among those of all; for the number of blocks, how
  // many values there are.
  Index diagonal_value(Index row) const { return diagonal_values_[At(row)]; }
  Index block_value(Index block) const { return block_values_[At(block)]; }

 private:
  static std::size_t At(Index i) { return static_cast<std::size_t>(i); }

  std::vector<int> sizes_;
  std::vector<Index> offsets_, diagonal_values_, block_values_;
  int uniform_size_ = 0;
  std::vector<std::size_t> first_;
  std::vector<Neighbor> neighbors_;
  std::vector<Index> block_of_pair_;
};

// Values on a pattern; blocks are row-major.
class BlockMatrix {
 public:
  // All zero.
  explicit BlockMatrix(std::shared_ptr<const BlockPattern> pattern);

  const BlockPattern& pattern() const { return *pattern_; }
  // Scalar rows.
  Index size() const { return pattern_->num_scalars(); }

  double* diagonal(Index row) { return diagonal_.data() + pattern_->diagonal_value(row); }
  const double* diagonal(Index row) const { return diagonal_.data() + pattern_->diagonal_value(row); }
  // The block of two rows, stored as that of the larger one's rows and the smaller one's columns.
  double* block(Index k) { return blocks_.data() + pattern_->block_value(k); }
  const double* block(Index k) const { return blocks_.data() + pattern_->block_value(k); }

  // y = this x. Sums go over the columns in ascending order.
  void Apply(HostSpan<const double> x, HostSpan<double> y) const;

 private:
  template <int D>
  void ApplyUniform(const double* x, double* y) const;
  void ApplyMixed(const double* x, double* y) const;

  std::shared_ptr<const BlockPattern> pattern_;
  HostBuffer<double> diagonal_, blocks_;
};

// H = J^T J of a block-sparse Jacobian, summed up as a sparse matrix.
//
// Which blocks H has, a row for each free block, and the terms of their sums: found once for a structure.
class BlockNormalMatrix {
 public:
  explicit BlockNormalMatrix(const BlockStructure& structure);

  const BlockPattern& pattern() const { return *pattern_; }
  // For Jacobians of that structure. Sums go over the residual blocks in their order, whatever the number of threads.
  // The memory of the matrix last given out is used again once nobody holds it.
  std::shared_ptr<const BlockMatrix> Sum(const BlockJacobian& jacobian);
  // Multiplications of one Sum, and the memory of this object: known without making one.
  static double Multiplications(const BlockStructure& structure);
  static double Bytes(const BlockStructure& structure);

 private:
  // A residual block that two free blocks share: their first columns in its dense Jacobian.
  struct Term {
    Index row;
    int larger, smaller;
  };

  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<std::size_t> first_term_;  // of each block under the diagonal, and the end
  std::vector<Term> terms_;
  Kept<BlockMatrix> matrix_;
};

}  // namespace vesta
