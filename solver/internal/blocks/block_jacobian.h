// SPDX-License-Identifier: Apache-2.0
// A block-sparse Jacobian held in memory, and its products.
#pragma once

#include <utility>

#include "kernels/core/vector_backend.h"
#include "solver/internal/blocks/block_structure.h"

namespace vesta {

// One small dense matrix a residual block, row after row, over a BlockStructure (borrowed). Products run in parallel
// with sums in a fixed order.
class BlockJacobian {
 public:
  using B = CpuBackend<double>;
  // Some of the free blocks.
  enum class Part { kAll, kKept, kEliminated };

  // Holds anything until it is written. storage: memory to use again, of any size.
  explicit BlockJacobian(const BlockStructure& structure, B::Vector storage = {})
      : structure_(structure), values_(std::move(storage)) {
    values_.ResizeForOverwrite(structure.num_values());
  }
  B::Vector TakeStorage() { return std::move(values_); }

  const BlockStructure& structure() const { return structure_; }
  double* row_values(Index row) { return values_.data() + At(row).value_offset; }
  const double* row_values(Index row) const { return values_.data() + At(row).value_offset; }

  // u = J v.
  void Apply(B::ConstVectorView v, B::VectorView u) const;
  // g = J^T u.
  void ApplyTranspose(B::ConstVectorView u, B::VectorView g) const;
  // d = diag(J^T J).
  void SquaredColumns(B::VectorView d) const;
  // The diagonal blocks of J^T J of one part, into a matrix of that part's groups. Overwrites.
  void Gram(Part part, BlockDiagonal<B>& diagonal) const;

 private:
  struct Range {
    int begin, end;  // free blocks
  };
  Range RangeOf(Part part) const;
  const BlockRow& At(Index row) const { return structure_.rows()[static_cast<std::size_t>(row)]; }
  const FreeBlock& Free(int free) const { return structure_.free_blocks()[static_cast<std::size_t>(free)]; }

  const BlockStructure& structure_;
  B::Vector values_;
};

}  // namespace vesta
