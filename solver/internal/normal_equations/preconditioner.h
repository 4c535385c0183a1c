// SPDX-License-Identifier: Apache-2.0
// Preconditioners of the damped normal equations H + lambda D. Each is told the diagonal, and the linearizations, once
// for each x, and the damping as often as it changes.
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
  kAuto,  // the problem's own if it has one, else block Jacobi if it has blocks, else Jacobi
  kIdentity,
  kJacobi,       // 1 / (diag(H) + lambda D)
  kBlockJacobi,  // the problem's diagonal blocks of H, damped; kJacobi where the problem has none
  kProblem,      // the problem's own (WithPreconditioner); as kAuto where it has none
  // The exact factor of H + lambda D (WithSparseCholesky): an iteration or two solve the system. Error where
  // the problem cannot give one (it has no blocks) or its factor would be over the problem's max_factor_gib.
  kSparseCholesky,
};
const char* ToString(PreconditionerKind kind);

template <Backend B>
class Preconditioner : public LinearOperator<B> {
 public:
  // H = the sum over the batches, which are borrowed until the next call; diag_h its diagonal.
  virtual void SetLinearization(std::span<LinearizationAdaptor<B>* const> batches,
                                typename B::ConstVectorView diag_h) = 0;
  virtual void SetDamping(double lambda, typename B::ConstVectorView metric) = 0;
  // Whether a column of zeros in H may get something but zero, or a zero give something to others: then PCG masks it.
  virtual bool couples_zero_columns() const { return true; }
  // Whether it is the inverse up to rounding: then one iteration is enough.
  virtual bool exact() const { return false; }
  // What it is, for the summary.
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
  // Entries whose damped diagonal is 0 stay 0.
  void SetDamping(double lambda, typename B::ConstVectorView metric) override;
  bool couples_zero_columns() const override { return false; }
  std::string description() const override { return ToString(PreconditionerKind::kJacobi); }

 private:
  typename B::Vector diagonal_, inverse_;
};

template <Backend B>
class BlockJacobiPreconditioner final : public Preconditioner<B> {
 public:
  // why: added to the description.
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
