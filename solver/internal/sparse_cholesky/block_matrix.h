// SPDX-License-Identifier: Apache-2.0
// Sparse symmetric matrices of small dense blocks, and the computation of H = J^T J in this form. Here a row means a
// row of blocks. Block (i, j) has size(i) scalar rows and size(j) scalar columns.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "kernels/core/buffer.h"
#include "solver/internal/blocks/block_jacobian.h"

namespace vesta {

// Get returns the previous object if no other pointer refers to it, else a new one.
template <class T>
class Reusable {
 public:
  template <class Make>
  std::shared_ptr<T> Get(const Make& make) {
    if (!last_ || last_.use_count() > 1) last_ = make();
    return last_;
  }

 private:
  std::shared_ptr<T> last_;
};

// The sizes of the rows, and the positions of the stored off-diagonal blocks. All diagonal blocks are stored.
class BlockPattern {
 public:
  // Rows of an off-diagonal block; a != b, in any order. A repeated pair is the same block.
  struct Pair {
    Index a, b;
  };
  // An off-diagonal block of a given row: its other row (column), and its index.
  struct Neighbor {
    Index row, block;
    bool operator==(const Neighbor&) const = default;
  };

  // sizes: scalars per row, >= 1. pairs: the off-diagonal blocks; 0 <= a, b < the number of rows.
  BlockPattern(std::span<const int> sizes, std::span<const Pair> pairs);

  Index num_rows() const { return static_cast<Index>(sizes_.size()); }
  // Number of blocks below the diagonal.
  Index num_blocks() const { return static_cast<Index>(neighbors_.size()) / 2; }
  int size(Index row) const { return sizes_[At(row)]; }
  // Index of the first scalar of a row; for num_rows(), the number of scalars.
  Index offset(Index row) const { return offsets_[At(row)]; }
  Index num_scalars() const { return offsets_.back(); }
  // The size of every row, or 0 if the sizes differ.
  int uniform_size() const { return uniform_size_; }
  // Sorted by row.
  std::span<const Neighbor> neighbors(Index row) const {
    return std::span(neighbors_).subspan(first_[At(row)], first_[At(row) + 1] - first_[At(row)]);
  }
  // Whether the other pattern has the same blocks, of any sizes.
  bool HasSamePlaces(const BlockPattern& other) const;
  // For each of the constructor's pairs, the index of its block.
  const std::vector<Index>& block_of_pair() const { return block_of_pair_; }
  // Position of the first value of a diagonal or off-diagonal block; for num_rows() or num_blocks(), the number of
  // values.
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

// The values of a matrix with a given pattern; blocks are row-major.
class BlockMatrix {
 public:
  // Initialises all values to zero.
  explicit BlockMatrix(std::shared_ptr<const BlockPattern> pattern);

  const BlockPattern& pattern() const { return *pattern_; }
  // Number of scalar rows.
  Index size() const { return pattern_->num_scalars(); }

  double* diagonal(Index row) { return diagonal_.data() + pattern_->diagonal_value(row); }
  const double* diagonal(Index row) const { return diagonal_.data() + pattern_->diagonal_value(row); }
  // A block below the diagonal: its row index is larger than its column index.
  double* block(Index k) { return blocks_.data() + pattern_->block_value(k); }
  const double* block(Index k) const { return blocks_.data() + pattern_->block_value(k); }

  // y = A x for this matrix A. Terms are added in ascending order of columns.
  void Apply(HostSpan<const double> x, HostSpan<double> y) const;

 private:
  template <int D>
  void ApplyUniform(const double* x, double* y) const;
  void ApplyMixed(const double* x, double* y) const;

  std::shared_ptr<const BlockPattern> pattern_;
  HostBuffer<double> diagonal_, blocks_;
};

// Computes H = J^T J of a block-sparse Jacobian, with one row of blocks per free parameter block.
//
// The constructor finds the nonzero blocks of H and the terms of their sums.
class BlockNormalMatrix {
 public:
  explicit BlockNormalMatrix(const BlockStructure& structure);
  // Leaves out the blocks of H to which only zero blocks of this Jacobian contribute. Sum then needs a Jacobian that is
  // zero in the same blocks.
  explicit BlockNormalMatrix(const BlockJacobian& jacobian);

  const BlockPattern& pattern() const { return *pattern_; }
  // Computes H; jacobian must have the structure of the constructor. For any number of threads, terms are added in the
  // order of the residual blocks. Reuses the memory of the previous result if that result is no longer in use.
  std::shared_ptr<const BlockMatrix> Sum(const BlockJacobian& jacobian);
  // Multiplications of one Sum, and bytes of a BlockNormalMatrix.
  static double Multiplications(const BlockStructure& structure);
  static double Bytes(const BlockStructure& structure);

 private:
  // A term of an off-diagonal block: a residual block (row) that depends on both free blocks, and their first columns
  // in its dense Jacobian. larger: the free block with the larger index.
  struct Term {
    Index row;
    int larger, smaller;
  };

  // cells_of(row): the cells of this BlockRow that count. reserve: number of their pairs, or 0 if not known.
  template <class CellsOf>
  BlockNormalMatrix(const BlockStructure& structure, std::size_t reserve, CellsOf cells_of);

  std::shared_ptr<const BlockPattern> pattern_;
  std::vector<std::size_t> first_term_;  // per block below the diagonal, and the end
  std::vector<Term> terms_;
  Reusable<BlockMatrix> matrix_;
};

}  // namespace vesta
