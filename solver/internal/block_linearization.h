// SPDX-License-Identifier: Apache-2.0
// Linearization of a BlockProblem.
#pragma once

#include <utility>

#include "solver/block_problem.h"
#include "solver/internal/blocks/block_jacobian.h"
#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/internal/sparse_cholesky/block_cholesky.h"

namespace vesta {

class BlockLinearization final : public Linearization<CpuBackend<double>>,
                                 public WithProductH<CpuBackend<double>>,
                                 public WithBlocks<CpuBackend<double>>,
                                 public WithReducedSystem<CpuBackend<double>>,
                                 public WithStoredJacobian,
                                 public NormalMatrixSource {
 public:
  using B = CpuBackend<double>;
  // Evaluates all residuals and Jacobians at x. Multiplies the Jacobians by the derivatives of the manifolds, and
  // corrects residuals and Jacobians for the losses (LossCorrection). The problem must outlive this object, and must
  // not change while this object exists.
  BlockLinearization(BlockProblem& problem, ConstVectorView x);
  ~BlockLinearization() override { memory_ = {jacobian_.TakeStorage(), std::move(residuals_), std::move(product_)}; }

  Index num_residuals() const override { return residuals_.size(); }
  Index num_parameters() const override { return jacobian_.structure().num_tangent(); }
  ConstVectorView residuals() const override { return residuals_.view(); }
  void ApplyJ(ConstVectorView v, VectorView u) override { jacobian_.Apply(v, u); }
  void ApplyJT(ConstVectorView u, VectorView g) override { jacobian_.ApplyTranspose(u, g); }
  void ApplyH(ConstVectorView v, VectorView Hv) override;
  void DiagJTJ(VectorView d) override { jacobian_.SquaredColumns(d); }
  std::vector<BlockGroup> block_groups() const override { return jacobian_.structure().groups(); }
  void BlockGram(BlockDiagonal<B>& diagonal) override { jacobian_.Gram(BlockJacobian::Part::kAll, diagonal); }
  std::unique_ptr<ReducedSystem<B>> MakeReducedSystem() override;
  void CopyJacobian(double* columns, Index leading) const override { jacobian_.Copy(columns, leading); }
  const BlockMatrix& NormalMatrix() override;

 private:
  using Scratch = BlockProblem::Scratch;
  // The same for one residual block, with index `row`.
  void EvaluateRow(const BlockProblem& problem, ConstVectorView x, Index row, Scratch& scratch);

  BlockProblem& problem_;
  BlockProblem::LinearizationMemory& memory_;  // owned by the problem
  BlockJacobian jacobian_;
  B::Vector residuals_;                               // corrected for the losses, like the Jacobian
  B::Vector product_;                                 // J v in ApplyH
  std::shared_ptr<const BlockMatrix> normal_matrix_;  // null until the first NormalMatrix()
};

}  // namespace vesta
