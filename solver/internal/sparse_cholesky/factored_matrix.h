// SPDX-License-Identifier: Apache-2.0
// A positive definite block matrix A and its sparse Cholesky factor, as the operator y = A^-1 x.
#pragma once

#include <memory>
#include <utility>

#include "solver/internal/sparse_cholesky/block_cholesky.h"
#include "solver/linear_operator.h"

namespace vesta {

class FactoredMatrix final : public LinearOperator<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;
  // cholesky: a plan for this pattern.
  FactoredMatrix(std::shared_ptr<const BlockPattern> pattern, SparseCholesky& cholesky)
      : matrix_(std::move(pattern)), no_damping_(matrix_.size()), factor_(cholesky.Factor()) {}

  // The values of A; zero before the caller sets them.
  BlockMatrix& matrix() { return matrix_; }
  // Factorises A, as BlockCholesky::Factorize does. Call it before Apply, and after each change of A.
  void Factorize() { factor_->Factorize(matrix_, 0.0, no_damping_); }
  Index size() const override { return matrix_.size(); }
  void Apply(B::ConstVectorView x, B::VectorView y) override { factor_->Solve(x, y); }

 private:
  BlockMatrix matrix_;
  HostBuffer<double> no_damping_;  // zero
  std::shared_ptr<BlockCholesky> factor_;
};

}  // namespace vesta
