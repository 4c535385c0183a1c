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
  kAuto,  // the problem's own if it has one, else kBlockJacobi if it has blocks, else kJacobi
  kIdentity,
  kJacobi,       // 1 / (diag(H) + lambda D)
  kBlockJacobi,  // the inverse of the damped diagonal blocks of H; kJacobi if the problem has no blocks
  kProblem,      // the problem's own (WithPreconditioner); like kAuto if it has none
  // The exact factor of H + lambda D (WithSparseCholesky); PCG then needs one or two iterations. Throws Error if the
  // problem has no blocks, or if the factor would exceed the problem's max_factor_gib.
  kSparseCholesky,
};
const char* ToString(PreconditionerKind kind);

template <Backend B>
class Preconditioner : public LinearOperator<B> {
 public:
  // H is the sum over the batches, which are borrowed until the next call. diag_h is its diagonal.
  virtual void SetLinearization(std::span<LinearizationAdaptor<B>* const> batches,
                                typename B::ConstVectorView diag_h) = 0;
  virtual void SetDamping(double lambda, typename B::ConstVectorView metric) = 0;
  // True if M^-1 may map a zero column of H to a nonzero value, or couple it with other columns. PCG then masks it.
  virtual bool couples_zero_columns() const { return true; }
  // True if this is the inverse up to rounding. One iteration is then enough.
  virtual bool exact() const { return false; }
  // Description for the summary.
  virtual std::string description() const { return ToString(PreconditionerKind::kProblem); }
};

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
  // Entries with a damped diagonal of 0 map to 0.
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
