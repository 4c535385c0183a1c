// SPDX-License-Identifier: Apache-2.0
// The Schur complement of a block-sparse Jacobian as an operator. It is never formed.
#pragma once

#include <span>
#include <vector>

#include "solver/internal/blocks/block_jacobian.h"
#include "solver/reduced_system.h"

namespace vesta {

// S = F^T F + lambda D_F - F^T E (E^T E + lambda D_E)^-1 E^T F, where F holds the kept and E the eliminated columns of
// J. A product reads J once. Borrows the Jacobian.
class BlockReducedSystem final : public ReducedSystem<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;
  explicit BlockReducedSystem(const BlockJacobian& jacobian);

  Index size() const override { return structure_.num_kept(); }
  void SetDamping(double lambda, ConstVectorView metric) override;
  void ReduceRhs(ConstVectorView rhs, VectorView reduced) override;
  void Apply(ConstVectorView x, VectorView y) override;
  void BackSubstitute(ConstVectorView rhs, VectorView step) override;
  std::vector<BlockGroup> kept_groups() const override { return structure_.kept_groups(); }
  void DiagonalBlocks(BlockDiagonal<B>& diagonal) override;

 private:
  std::span<const FreeBlock> EliminatedBlocks() const {
    return std::span(structure_.free_blocks()).subspan(static_cast<std::size_t>(structure_.num_kept_blocks()));
  }
  Index num_eliminated() const { return structure_.num_tangent() - structure_.num_kept(); }
  // Reads the rows once, eliminated block by eliminated block. Computes y = C^-1 (b - E^T F x) and u = F x + E y, and
  // writes F^T u to `kept` and y to `eliminated`. An empty x or b means 0; an empty output is not computed.
  void PassRows(ConstVectorView x, ConstVectorView b, VectorView kept, VectorView eliminated);
  // out(k, k) -= W C^-1 W^T for one kept block. W = F_k^T E over the rows that it shares with each eliminated block.
  void SubtractFill(int free, BlockDiagonal<B>& diagonal) const;

  const BlockJacobian& jacobian_;
  const BlockStructure& structure_;
  double lambda_ = 0;
  B::Vector kept_metric_;
  BlockDiagonal<B> eliminated_;  // C, later its Cholesky factors
  // The same factors, one block after another, each a packed lower triangle.
  B::Vector factors_;
  std::vector<Index> first_factor_;
  std::vector<Index> rows_alone_;  // rows without an eliminated block
  // F^T u is summed over a fixed number of ranges of eliminated blocks, each into its own vector. These vectors are
  // then added in order. So the rows are read once, and the result does not depend on the number of threads.
  Index num_ranges_;
  B::Vector partial_;
};

}  // namespace vesta
