// SPDX-License-Identifier: Apache-2.0
// H = J^T J of a block-sparse Jacobian, summed up as a sparse matrix.
#pragma once

#include <memory>
#include <vector>

#include "solver/internal/blocks/block_jacobian.h"
#include "solver/internal/sparse_cholesky/block_matrix.h"
#include "solver/internal/sparse_cholesky/kept.h"

namespace vesta {

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
