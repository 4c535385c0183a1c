// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/sparse_cholesky/sparse_cholesky_preconditioner.h"

#include <fmt/format.h>

#include <utility>

#include "kernels/core/check.h"

namespace vesta {

std::shared_ptr<SparseCholesky> SparseCholesky::Plan(const BlockPattern& pattern, double max_bytes,
                                                     double max_multiplications) {
  std::optional<EliminationPlan> plan =
      PlanElimination(pattern, {.factor_values = max_bytes / sizeof(double), .multiplications = max_multiplications});
  // Joined fronts store more, and their rows are padded.
  if (!plan || BlockCholesky::Bytes(*plan) > max_bytes || plan->multiplications > max_multiplications) return nullptr;
  return std::shared_ptr<SparseCholesky>(new SparseCholesky(std::move(*plan)));
}

SparseCholeskyPreconditioner::SparseCholeskyPreconditioner(std::shared_ptr<SparseCholesky> cholesky, std::string why)
    : cholesky_(std::move(cholesky)), why_(std::move(why)) {}

void SparseCholeskyPreconditioner::SetLinearization(std::span<LinearizationAdaptor<B>* const> batches,
                                                    B::ConstVectorView /*diag_h*/) {
  VESTA_CHECK(batches.size() == 1, "a sparse Cholesky factor is of one batch, not of {}", batches.size());
  source_ = dynamic_cast<NormalMatrixSource*>(&batches.front()->get());
  VESTA_CHECK(source_ != nullptr, "this preconditioner is for linearizations of its own problem");
}

void SparseCholeskyPreconditioner::SetDamping(double lambda, B::ConstVectorView metric) {
  VESTA_CHECK(source_ != nullptr, "SetLinearization comes before SetDamping");
  if (!factor_) factor_ = cholesky_->Factor();
  num_raised_ = factor_->Factorize(source_->NormalMatrix(), lambda, metric);
}

std::string SparseCholeskyPreconditioner::description() const {
  return fmt::format("{} of {:.1f} MiB{}", ToString(PreconditionerKind::kSparseCholesky), cholesky_->bytes() / 0x1p20,
                     why_);
}

}  // namespace vesta
