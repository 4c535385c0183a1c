// SPDX-License-Identifier: Apache-2.0
// Symmetric block-diagonal matrices, such as block-Jacobi preconditioners.
#pragma once

#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/core/hd.h"
#include "kernels/core/packed.h"

namespace vesta {

// `count` square blocks of order `size`. Component c of block i is parameter
//   offset + c * component_stride + i * block_stride,
// Structure of arrays: component_stride = count, block_stride = 1. Array of structures: component_stride = 1,
// block_stride = size.
struct BlockGroup {
  int size = 1;
  Index count = 0;
  Index offset = 0;
  Index component_stride = 1;
  Index block_stride = 1;

  VESTA_HD Index Parameter(Index block, int component) const {
    return offset + component * component_stride + block * block_stride;
  }
  // Number of stored values: the lower triangles of all blocks (packed.h).
  Index NumValues() const { return count * PackedSize(size); }
};

// A symmetric block-diagonal matrix over the parameters 0..num_parameters-1. The groups must cover each parameter
// exactly once. Element (row, col) of block i of group g is values(g)[PackedLower(row, col) * count + i]. With this
// layout, 16 blocks are factorised at once in vector registers. B is a vector backend (vector_backend.h).
template <class B>
class BlockDiagonal {
 public:
  using Scalar = typename B::Scalar;

  BlockDiagonal(Index num_parameters, std::vector<BlockGroup> groups);

  Index num_parameters() const { return num_parameters_; }
  const std::vector<BlockGroup>& groups() const { return groups_; }
  typename B::VectorView values(int group);
  typename B::ConstVectorView values(int group) const;
  typename B::VectorView all_values();

  // this += scale * other. Both must have the same groups.
  void Add(double scale, const BlockDiagonal& other);
  // this(k, k) += scale * d[k].
  void AddToDiagonal(double scale, typename B::ConstVectorView d);
  // out[k] = this(k, k).
  void Diagonal(typename B::VectorView out) const;
  // y = this x.
  void Apply(typename B::ConstVectorView x, typename B::VectorView y) const;

  // Replaces every block by its Cholesky factor L, with 1 / L_kk on the diagonal. Must precede Solve. If a diagonal
  // entry is not positive and finite, its row and column are treated as zero, and Solve returns 0 there. A pivot below
  // 1e-6 (in double: 1e-13) times its diagonal entry is raised to that value, because a preconditioner must be positive
  // definite but need not be exact. Returns the number of such diagonal entries and raised pivots. Finite input always
  // gives finite output.
  Index Factorize();
  // y = this^-1 x, after Factorize. x and y may be the same memory.
  void Solve(typename B::ConstVectorView x, typename B::VectorView y) const;

 private:
  Index num_parameters_;
  std::vector<BlockGroup> groups_;
  std::vector<Index> first_value_;
  typename B::Vector values_;
};

}  // namespace vesta

namespace vesta::device {

// GPU versions for one group, defined in block_diagonal.cu. Each thread processes one block; neighbouring threads read
// neighbouring values.
//
// Largest order of a block. A thread keeps the block in local memory.
inline constexpr int kMaxBlockOrder = 32;

// All pointers are to GPU memory. values: the NumValues() values of the group. num_replaced: FactorizeBlocks adds to it
// the group's part of the number that BlockDiagonal::Factorize returns.
template <class S>
void AddToBlockDiagonal(const BlockGroup& group, double scale, const S* d, S* values);
template <class S>
void BlockDiagonalOf(const BlockGroup& group, const S* values, S* out);
template <class S>
void MultiplyBlocks(const BlockGroup& group, const S* values, const S* x, S* y);
template <class S>
void FactorizeBlocks(const BlockGroup& group, S* values, unsigned long long* num_replaced);
template <class S>
void SolveBlocks(const BlockGroup& group, const S* values, const S* x, S* y);

}  // namespace vesta::device
