// SPDX-License-Identifier: Apache-2.0
// The exact sparse Cholesky factor of H + lambda D as a preconditioner: conjugate gradients then take an iteration or
// two.
#pragma once

#include <memory>
#include <string>

#include "solver/internal/normal_equations/preconditioner.h"
#include "solver/internal/sparse_cholesky/block_cholesky.h"
#include "solver/internal/sparse_cholesky/kept.h"

namespace vesta {

// A linearization that can give H as a matrix.
class NormalMatrixSource {
 public:
  virtual ~NormalMatrixSource() = default;
  // H = J^T W J, on a pattern that all linearizations of a problem share. Made when first asked for; valid as long as
  // this object.
  virtual const BlockMatrix& NormalMatrix() = 0;
};

// What a problem keeps from one linearization, and from one solve, to the next: the plan, and the factor's memory.
class SparseCholesky {
 public:
  // Plans for a pattern. Null where the factor would take more than max_bytes, or factorising it more than
  // max_multiplications.
  static std::shared_ptr<SparseCholesky> Plan(const BlockPattern& pattern, double max_bytes,
                                              double max_multiplications = std::numeric_limits<double>::infinity());

  const EliminationPlan& plan() const { return *plan_; }
  double bytes() const { return BlockCholesky::Bytes(*plan_); }
  // The factor last given out where nobody holds it any more, since its memory is large; otherwise another one.
  std::shared_ptr<BlockCholesky> Factor() {
    return factor_.Get([&] { return std::make_shared<BlockCholesky>(plan_); });
  }

 private:
  explicit SparseCholesky(EliminationPlan plan) : plan_(std::make_shared<EliminationPlan>(std::move(plan))) {}

  std::shared_ptr<const EliminationPlan> plan_;
  Kept<BlockCholesky> factor_;
};

class SparseCholeskyPreconditioner final : public Preconditioner<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;
  // For linearizations that are NormalMatrixSources on the pattern that was planned for. why: added to the description.
  explicit SparseCholeskyPreconditioner(std::shared_ptr<SparseCholesky> cholesky, std::string why = "");

  Index size() const override { return cholesky_->plan().num_scalars; }
  // After SetDamping.
  void Apply(B::ConstVectorView x, B::VectorView y) override { factor_->Solve(x, y); }
  void SetLinearization(std::span<LinearizationAdaptor<B>* const> batches, B::ConstVectorView diag_h) override;
  void SetDamping(double lambda, B::ConstVectorView metric) override;
  bool exact() const override { return true; }
  // Pivots of the last damping that had cancelled, and were raised (BlockCholesky::Factorize).
  Index num_raised() const { return num_raised_; }
  std::string description() const override;

 private:
  std::shared_ptr<SparseCholesky> cholesky_;
  std::string why_;
  NormalMatrixSource* source_ = nullptr;
  std::shared_ptr<BlockCholesky> factor_;  // from the first damping on
  Index num_raised_ = 0;
};

}  // namespace vesta
