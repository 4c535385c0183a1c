// SPDX-License-Identifier: Apache-2.0
// The Schur complement of J^T J + lambda D for a block-sparse Jacobian J, as an operator. The matrix is never formed.
#pragma once

#include <span>
#include <vector>

#include "solver/internal/blocks/block_jacobian.h"
#include "solver/reduced_system.h"

namespace vesta {

// S = F^T F + lambda D_F - F^T E C^-1 E^T F with C = E^T E + lambda D_E. J = [F E]: F has the columns of the kept
// parameters, E the columns of the eliminated ones. C is block-diagonal. A product with S reads J once. The Jacobian
// must outlive this object.
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
  // Computes y = C^-1 (b - E^T F x) and u = F x + E y, and writes F^T u to `kept` and y to `eliminated`. Processes one
  // eliminated block after another, so each row of J is read only once. An empty x or b means 0; an empty output is not
  // computed.
  void PassRows(ConstVectorView x, ConstVectorView b, VectorView kept, VectorView eliminated);
  // Subtracts F_k^T E C^-1 E^T F_k from the diagonal block of kept block k = `free`. This is the diagonal block of F^T
  // E C^-1 E^T F.
  void SubtractFill(int free, BlockDiagonal<B>& diagonal) const;

  const BlockJacobian& jacobian_;
  const BlockStructure& structure_;
  double lambda_ = 0;
  B::Vector kept_metric_;
  BlockDiagonal<B> eliminated_;  // C, later its Cholesky factors
  // The same factors, one block after another, each as a packed lower triangle.
  B::Vector factors_;
  std::vector<Index> first_factor_;  // per eliminated block: position in factors_
  std::vector<Index> rows_alone_;    // rows without an eliminated block
  // The eliminated blocks are divided into a fixed number of ranges. F^T u of each range is summed into its own vector
  // in partial_. These vectors are then added in order. So the result does not depend on the number of threads.
  Index num_ranges_;
  B::Vector partial_;
};

}  // namespace vesta
