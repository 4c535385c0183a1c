// SPDX-License-Identifier: Apache-2.0
// A stored block-sparse Jacobian and its products.
#pragma once

#include <utility>

#include "kernels/core/vector_backend.h"
#include "solver/internal/blocks/block_structure.h"

namespace vesta {

// The Jacobian J with respect to the free parameter blocks (blocks that are not constant). Stores one dense row-major
// matrix per residual block, at the positions given by a BlockStructure. Products run in parallel. Their sums have a
// fixed order, so results do not depend on the number of threads.
class BlockJacobian {
 public:
  using B = CpuBackend<double>;
  // A subset of the free blocks.
  enum class Part { kAll, kKept, kEliminated };

  // The values are not initialised. structure must outlive this object. storage: memory to reuse, of any size.
  explicit BlockJacobian(const BlockStructure& structure, B::Vector storage = {})
      : structure_(structure), values_(std::move(storage)) {
    values_.ResizeForOverwrite(structure.num_values());
  }
  // Returns the memory of the values for reuse. Do not use this object afterwards.
  B::Vector TakeStorage() { return std::move(values_); }

  const BlockStructure& structure() const { return structure_; }
  // The dense Jacobian of residual block `row`.
  double* row_values(Index row) { return values_.data() + At(row).value_offset; }
  const double* row_values(Index row) const { return values(At(row)); }
  const double* values(const BlockRow& row) const { return values_.data() + row.value_offset; }

  // Writes the nonzero entries: entry (i, k) of J to columns[k * leading + i].
  void Copy(double* columns, Index leading) const;
  // u = J v.
  void Apply(B::ConstVectorView v, B::VectorView u) const;
  // g = J^T u.
  void ApplyTranspose(B::ConstVectorView u, B::VectorView g) const;
  // d = diag(J^T J).
  void SquaredColumns(B::VectorView d) const;
  // Overwrites `diagonal` with the diagonal blocks of J^T J for the free blocks of `part`. `diagonal` must have the
  // groups of `part` (BlockStructure::groups, kept_groups or eliminated_groups).
  void Gram(Part part, BlockDiagonal<B>& diagonal) const;

 private:
  struct Range {
    int begin, end;  // indices of free blocks
  };
  Range RangeOf(Part part) const;
  const BlockRow& At(Index row) const { return structure_.rows()[static_cast<std::size_t>(row)]; }
  const FreeBlock& Free(int free) const { return structure_.free_blocks()[static_cast<std::size_t>(free)]; }

  const BlockStructure& structure_;
  B::Vector values_;
};

}  // namespace vesta
