// SPDX-License-Identifier: Apache-2.0
// Preconditioners of the damped normal equations H + lambda D. SetLinearization is called once per x, SetDamping
// whenever the damping changes.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/linear_operator.h"

namespace vesta {

enum class PreconditionerKind {
  kAuto,      // the problem's own (WithPreconditioner) if it has one, else kBlockJacobi if it has blocks, else kJacobi
  kIdentity,  // no preconditioner
  kJacobi,    // the inverse of diag(H) + lambda D
  kBlockJacobi,  // the inverse of the damped diagonal blocks of H; kJacobi if the problem has no blocks
  kProblem,      // the same as kAuto
  // The sparse Cholesky factor of H + lambda D (WithSparseCholesky). PCG then needs one or two iterations. The solve
  // throws Error if the problem provides no factor, or if the factor would exceed the problem's max_factor_gib.
  kSparseCholesky,
};
const char* ToString(PreconditionerKind kind);

// Apply computes y = M^-1 x, where M approximates H + lambda D. SetLinearization and SetDamping are called before
// Apply.
template <Backend B>
class Preconditioner : public LinearOperator<B> {
 public:
  // H is the sum over the batches, which stay valid until the next call. diag_h: the diagonal of H, valid only during
  // the call.
  virtual void SetLinearization(std::span<LinearizationAdaptor<B>* const> batches,
                                typename B::ConstVectorView diag_h) = 0;
  // metric: the diagonal of D.
  virtual void SetDamping(double lambda, typename B::ConstVectorView metric) = 0;
  // True if M^-1 may couple a zero column of H with other columns. PCG then masks the zero columns.
  virtual bool couples_zero_columns() const { return true; }
  // True if M = H + lambda D up to rounding. One iteration of PCG is then enough.
  virtual bool exact() const { return false; }
  // Description for the summary.
  virtual std::string description() const { return ToString(PreconditionerKind::kProblem); }
};

// Creates the preconditioner of this kind. Calls neither SetLinearization nor SetDamping.
template <Backend B>
std::unique_ptr<Preconditioner<B>> MakePreconditioner(PreconditionerKind kind, ProblemAdaptor<B> problem,
                                                      std::span<LinearizationAdaptor<B>* const> batches);

template <Backend B>
class IdentityPreconditioner final : public Preconditioner<B> {
 public:
  explicit IdentityPreconditioner(Index size = 0) : size_(size) {}
  Index size() const override { return size_; }
  void Apply(typename B::ConstVectorView x, typename B::VectorView y) override;
  void SetLinearization(std::span<LinearizationAdaptor<B>* const> batches, typename B::ConstVectorView diag_h) override;
  void SetDamping(double lambda, typename B::ConstVectorView metric) override;
  bool couples_zero_columns() const override { return false; }
  std::string description() const override { return ToString(PreconditionerKind::kIdentity); }

 private:
  Index size_;
};

template <Backend B>
class JacobiPreconditioner final : public Preconditioner<B> {
 public:
  Index size() const override { return diagonal_.size(); }
  void Apply(typename B::ConstVectorView x, typename B::VectorView y) override;
  void SetLinearization(std::span<LinearizationAdaptor<B>* const> batches, typename B::ConstVectorView diag_h) override;
  // If an entry of diag(H) + lambda D is 0, Apply writes 0 there.
  void SetDamping(double lambda, typename B::ConstVectorView metric) override;
  bool couples_zero_columns() const override { return false; }
  std::string description() const override { return ToString(PreconditionerKind::kJacobi); }

 private:
  typename B::Vector diagonal_, inverse_;
};

template <Backend B>
class BlockJacobiPreconditioner final : public Preconditioner<B> {
 public:
  // why: the reason for the choice, appended to the description.
  explicit BlockJacobiPreconditioner(std::string why = "") : why_(std::move(why)) {}
  Index size() const override;
  void Apply(typename B::ConstVectorView x, typename B::VectorView y) override;
  void SetLinearization(std::span<LinearizationAdaptor<B>* const> batches, typename B::ConstVectorView diag_h) override;
  void SetDamping(double lambda, typename B::ConstVectorView metric) override;
  bool couples_zero_columns() const override { return false; }
  std::string description() const override { return ToString(PreconditionerKind::kBlockJacobi) + why_; }

 private:
  std::string why_;
  std::span<LinearizationAdaptor<B>* const> batches_;
  std::optional<BlockDiagonal<B>> factors_;
  std::optional<double> factored_lambda_;
};

}  // namespace vesta
