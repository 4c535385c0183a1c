// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/internal/normal_equations/preconditioner.h.
#pragma once

#include "kernels/core/check.h"
#include "solver/internal/normal_equations/preconditioner.h"

namespace vesta {

template <Backend B>
std::unique_ptr<Preconditioner<B>> MakePreconditioner(PreconditionerKind kind, ProblemAdaptor<B> problem,
                                                      std::span<LinearizationAdaptor<B>* const> batches) {
  if (kind == PreconditionerKind::kSparseCholesky) {
    auto factor = problem.MakeSparseCholesky();
    if (!factor) Fail(kUnsupported, "preconditioner = {} needs a problem of blocks; choose kAuto", ToString(kind));
    return factor;
  }
  if (kind == PreconditionerKind::kAuto || kind == PreconditionerKind::kProblem) {
    if (auto made = problem.MakePreconditioner()) return made;
    kind = PreconditionerKind::kBlockJacobi;
  }
  if (kind == PreconditionerKind::kIdentity) return std::make_unique<IdentityPreconditioner<B>>();
  const bool has_blocks = !batches.empty() && !batches.front()->block_groups().empty();
  if (kind == PreconditionerKind::kBlockJacobi && has_blocks) return std::make_unique<BlockJacobiPreconditioner<B>>();
  return std::make_unique<JacobiPreconditioner<B>>();
}

template <Backend B>
void IdentityPreconditioner<B>::Apply(typename B::ConstVectorView x, typename B::VectorView y) {
  B().Copy(x, y);
}

template <Backend B>
void IdentityPreconditioner<B>::SetLinearization(std::span<LinearizationAdaptor<B>* const>,
                                                 typename B::ConstVectorView diag_h) {
  size_ = diag_h.size();
}

template <Backend B>
void IdentityPreconditioner<B>::SetDamping(double, typename B::ConstVectorView) {}

template <Backend B>
void JacobiPreconditioner<B>::Apply(typename B::ConstVectorView x, typename B::VectorView y) {
  B().Multiply(inverse_, x, y);
}

template <Backend B>
void JacobiPreconditioner<B>::SetLinearization(std::span<LinearizationAdaptor<B>* const>,
                                               typename B::ConstVectorView diag_h) {
  diagonal_.Resize(diag_h.size());
  B().Copy(diag_h, diagonal_);
}

template <Backend B>
void JacobiPreconditioner<B>::SetDamping(double lambda, typename B::ConstVectorView metric) {
  B backend;
  if (inverse_.size() != diagonal_.size()) inverse_.Resize(diagonal_.size());
  typename B::Vector one(diagonal_.size());
  backend.Fill(1, one);
  backend.Copy(diagonal_, inverse_);
  backend.Axpby(lambda, metric, 1.0, inverse_);
  backend.DivideOrZero(one, inverse_, inverse_);
}

template <Backend B>
Index BlockJacobiPreconditioner<B>::size() const {
  return factors_ ? factors_->num_parameters() : 0;
}

template <Backend B>
void BlockJacobiPreconditioner<B>::Apply(typename B::ConstVectorView x, typename B::VectorView y) {
  factors_->Solve(x, y);
}

template <Backend B>
void BlockJacobiPreconditioner<B>::SetLinearization(std::span<LinearizationAdaptor<B>* const> batches,
                                                    typename B::ConstVectorView diag_h) {
  batches_ = batches;
  factors_.reset();
  factors_.emplace(diag_h.size(), batches.front()->block_groups());
  factored_lambda_.reset();
}

template <Backend B>
void BlockJacobiPreconditioner<B>::SetDamping(double lambda, typename B::ConstVectorView metric) {
  if (factored_lambda_ == lambda) return;
  // The factors overwrite the blocks, so only one matrix is stored. Another lambda at the same x occurs only after a
  // rejected step; the blocks are then computed again.
  if (factored_lambda_) B().Fill(0, factors_->all_values());
  batches_.front()->BlockGram(*factors_);
  std::optional<BlockDiagonal<B>> part;
  for (LinearizationAdaptor<B>* batch : batches_.subspan(1)) {
    part.emplace(factors_->num_parameters(), factors_->groups());
    batch->BlockGram(*part);
    factors_->Add(1.0, *part);
  }
  factors_->AddToDiagonal(lambda, metric);
  factors_->Factorize();
  factored_lambda_ = lambda;
}

}  // namespace vesta
