// SPDX-License-Identifier: Apache-2.0
// The sparse Cholesky factor of the reduced matrix: with it conjugate gradients take one or two iterations, whatever
// the size of the problem.
#pragma once

#include <memory>
#include <string>

#include "problems/bundle_adjustment/structure.h"
#include "solver/internal/sparse_cholesky/block_cholesky.h"
#include "solver/linear_operator.h"

namespace vesta::bundle::internal {

// What all factors of one problem share: the order of elimination, and memory.
class ReducedCholeskyPlan {
 public:
  // Null where only the diagonal blocks are formed, and where factorising would take longer than some hundred products
  // with the matrix: conjugate gradients with its diagonal blocks need fewer as a rule.
  static std::shared_ptr<ReducedCholeskyPlan> Make(const ReducedPattern& pattern);

  std::string description() const;

 private:
  friend class ReducedCholesky;
  ReducedCholeskyPlan() = default;

  std::shared_ptr<const BlockPattern> pattern_;  // of the lower triangle; the reduced matrix has the upper one
  std::shared_ptr<SparseCholesky> cholesky_;
};

// One factor.
class ReducedCholesky final : public LinearOperator<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;
  explicit ReducedCholesky(const ReducedCholeskyPlan& plan);

  // Factorises the matrix of these blocks, laid out by the pattern that was planned for as kernels.h has it.
  void Factorize(const ReducedPattern& pattern, const double* blocks);
  Index size() const override { return matrix_.size(); }
  void Apply(B::ConstVectorView x, B::VectorView y) override { factor_->Solve(x, y); }

 private:
  BlockMatrix matrix_;
  HostBuffer<double> no_damping_;  // the blocks have it
  std::shared_ptr<BlockCholesky> factor_;
};

}  // namespace vesta::bundle::internal
