// SPDX-License-Identifier: Apache-2.0
// The Schur complement of J^T J + lambda D for a block-sparse Jacobian J, as an operator, and its Cholesky factor.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "solver/internal/blocks/block_jacobian.h"
#include "solver/internal/linear/cross_product.h"
#include "solver/internal/reduced/couplings.h"
#include "solver/internal/reduced/reduced_matrix.h"
#include "solver/reduced_system.h"

namespace vesta {

// S = F^T F + lambda D_F - F^T E C^-1 E^T F with C = E^T E + lambda D_E. J = [F E]: F has the columns of the kept
// parameters, E the columns of the eliminated ones. C is block-diagonal. A product with S reads J once. Only Factorize
// forms the matrix S.
class BlockReducedSystem final : public ReducedSystem<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;
  // Returns the plan of the factor of S. Null if Schur-Jacobi is preferred; never null if `always` is true.
  using PlanOf = std::function<std::shared_ptr<ReducedMatrixPlan>(bool always)>;
  // The Jacobian and the couplings must outlive this object.
  BlockReducedSystem(const BlockJacobian& jacobian, const Couplings& couplings, PlanOf plan_of);

  Index size() const override { return structure_.num_kept(); }
  void SetDamping(double lambda, ConstVectorView metric) override;
  void ReduceRhs(ConstVectorView rhs, VectorView reduced) override;
  void Apply(ConstVectorView x, VectorView y) override;
  void BackSubstitute(ConstVectorView rhs, VectorView step) override;
  std::vector<BlockGroup> kept_groups() const override { return structure_.kept_groups(); }
  void DiagonalBlocks(BlockDiagonal<B>& diagonal) override;
  bool PlanFactor(bool always) override { return (plan_ = plan_of_(always)) != nullptr; }
  LinearOperator<B>* Factorize() override;
  std::string factor_description() const override { return plan_ ? plan_->description() : ""; }

 private:
  std::span<const FreeBlock> EliminatedBlocks() const {
    return std::span(structure_.free_blocks()).subspan(static_cast<std::size_t>(structure_.num_kept_blocks()));
  }
  Index num_eliminated() const { return structure_.num_tangent() - structure_.num_kept(); }
  // Computes y = C^-1 (b - E^T F x) and u = F x + E y, and writes F^T u to `kept` and y to `eliminated`. Processes one
  // eliminated block after another, so each row of J is read only once. An empty x or b means 0; an empty output is not
  // computed.
  void PassRows(ConstVectorView x, ConstVectorView b, VectorView kept, VectorView eliminated);
  // Computes V = L^-1 E^T F for the blocks of a coupling, where L L^T is the block of C. The block of F^T E C^-1 E^T F
  // for two kept blocks is the sum of V_1^T V_2 over the eliminated blocks that are coupled to both.
  void ReduceCoupling(const Coupling& coupling, double* v) const;
  // Computes the blocks of S in row k, up to the diagonal. V of all couplings must be in `couplings`. block_of: work
  // memory, with one pointer per kept block.
  void FormRow(int k, std::vector<double*>& block_of, ReducedMatrixPlan::Memory& memory) const;
  const FreeBlock& Free(int k) const { return structure_.free_blocks()[static_cast<std::size_t>(k)]; }
  const FreeBlock& Eliminated(int e) const { return Free(structure_.num_kept_blocks() + e); }

  const BlockJacobian& jacobian_;
  const BlockStructure& structure_;
  const Couplings& couplings_;
  PlanOf plan_of_;
  AddCrossProduct* cross_product_;
  std::shared_ptr<ReducedMatrixPlan> plan_;            // null without a factor
  std::shared_ptr<ReducedMatrixPlan::Memory> memory_;  // null before Factorize
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
