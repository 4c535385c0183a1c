// SPDX-License-Identifier: Apache-2.0
// Linear solvers that compute the damped step by PCG: PcgStep for all parameters, ShardedPcgStep with vectors divided
// among processes, and ReducedPcgStep with a group of parameters eliminated.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/profile.h"
#include "solver/internal/normal_equations/damped_normal_equations.h"
#include "solver/internal/normal_equations/step_solver.h"
#include "solver/reduced_system.h"

namespace vesta::step_internal {

// Computes g^T step and step^T H step without another product with H, from (H + lambda D) step = d - r, where r is the
// residual of PCG. r_dot_step: r^T step.
template <Backend B>
StepSolution FromResidual(const StepSystem<B>& system, PcgSummary pcg, double lambda, double r_dot_step,
                          typename B::VectorView step) {
  const double b_dot_step = system.backend.Dot(system.rhs, step);
  const double descent = system.negative_gradient.data() == system.rhs.data()
                             ? b_dot_step
                             : system.backend.Dot(system.negative_gradient, step);
  const double damping = lambda * system.backend.WeightedDot(system.metric, step, step);
  return {pcg, -descent, std::max(0.0, b_dot_step - r_dot_step - damping)};
}

// y = M^-1 x, but y = 0 where the mask is 0. M itself may couple such entries with other entries, although the system
// does not couple them.
template <Backend B>
class MaskedPreconditioner final : public LinearOperator<B> {
 public:
  MaskedPreconditioner(B& backend, LinearOperator<B>& inner, typename B::ConstVectorView mask)
      : backend_(backend), inner_(inner), mask_(mask) {}
  Index size() const override { return inner_.size(); }
  void Apply(typename B::ConstVectorView x, typename B::VectorView y) override {
    inner_.Apply(x, y);
    if (!mask_.empty()) backend_.Multiply(mask_, y, y);
  }

 private:
  B& backend_;
  LinearOperator<B>& inner_;
  typename B::ConstVectorView mask_;
};

// Relative tolerance of the residual of PCG if the preconditioner is the exact inverse.
constexpr double kExactTolerance = 1e-10;

template <Backend B>
class PcgStep final : public StepSolver<B> {
 public:
  PcgStep(const NormalSystemOptions& options, const StepSystem<B>& system, const InnerProducts<B>* products = nullptr)
      : options_(options),
        system_(system),
        products_(products ? *products : whole_products_),
        preconditioner_(MakePreconditioner<B>(options.preconditioner, system.problem, system.batches)) {
    // Without a test of the residual, PCG would compute a second iteration although the first one solves the system.
    double& tolerance = options_.pcg.relative_tolerance;
    if (preconditioner_->exact() && tolerance == 0) tolerance = kExactTolerance;
    const ScopedPhase phase("preconditioner");
    preconditioner_->SetLinearization(system.batches, system.diagonal);
    // Without bounds, the mask is 0 only for zero columns. Their right-hand side is 0. So PCG leaves the step of a zero
    // column at 0 even without a mask, unless the preconditioner couples this column with others.
    if (!system.problem.has_bounds() && !preconditioner_->couples_zero_columns()) system_.mask = {};
  }
  bool reads_mask() const override { return !system_.mask.empty(); }
  std::string preconditioner() const { return preconditioner_->description(); }
  // Solves by PCG, but does not compute the values of the quadratic model.
  PcgSummary Iterate(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step) {
    {
      const ScopedPhase phase("preconditioner");
      preconditioner_->SetDamping(options_.preconditioner_lambda.value_or(lambda), system_.metric);
    }
    DampedNormalEquations<B> damped({system_.batches.begin(), system_.batches.end()}, lambda, system_.metric,
                                    system_.mask);
    MaskedPreconditioner<B> masked(system_.backend, *preconditioner_, system_.mask);
    return SolvePcg<B>(options_.pcg, system_.backend, damped, system_.rhs, masked, workspace, step,
                       system_.scale.square, products_);
  }
  StepSolution Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step) override {
    const PcgSummary pcg = Iterate(lambda, workspace, step);
    return FromResidual(system_, pcg, lambda, products_.Dot(workspace.residual(), step), step);
  }

 private:
  NormalSystemOptions options_;
  StepSystem<B> system_;
  InnerProducts<B> whole_products_;
  const InnerProducts<B>& products_;
  std::unique_ptr<Preconditioner<B>> preconditioner_;
};

// The same, with the PCG vectors and the preconditioner divided among processes (ShardedSystem).
template <Backend B>
class ShardedPcgStep final : public StepSolver<B> {
 public:
  ShardedPcgStep(const NormalSystemOptions& options, const StepSystem<B>& system,
                 std::unique_ptr<ShardedSystem<B>> sharded)
      : system_(system), sharded_(std::move(sharded)), adaptor_(*sharded_) {
    const auto of = [&](typename B::ConstVectorView whole, typename B::Vector& storage) {
      return whole.empty() ? whole : sharded_->ShardOf(whole, storage);
    };
    if (!system.scale.square.empty()) {
      scale_.square.Resize(sharded_->num_parameters());
      system.backend.Copy(of(system.scale.square.view(), diagonal_), scale_.square);
    }
    const typename B::ConstVectorView rhs = of(system.rhs, rhs_);
    inner_.emplace(options,
                   StepSystem<B>{.backend = system.backend,
                                 .problem = system.problem,
                                 .batches = {&batch_, 1},
                                 .diagonal = of(system.diagonal, diagonal_),
                                 .metric = of(system.metric, metric_),
                                 .mask = of(system.mask, mask_),
                                 .rhs = rhs,
                                 .negative_gradient = rhs,
                                 .scale = scale_},
                   &sharded_->products());
    diagonal_ = {};  // the preconditioner has its own copy
    if (!inner_->reads_mask()) mask_ = {};
  }
  bool reads_mask() const override { return inner_->reads_mask(); }
  std::string preconditioner() const { return inner_->preconditioner(); }
  StepSolution Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step) override {
    typename B::Vector shard(sharded_->num_parameters());
    const PcgSummary pcg = inner_->Iterate(lambda, workspace, shard);
    const double r_dot_step = sharded_->products().Dot(workspace.residual(), shard.view());
    sharded_->Gather(shard, step);
    return FromResidual(system_, pcg, lambda, r_dot_step, step);
  }

 private:
  StepSystem<B> system_;
  std::unique_ptr<ShardedSystem<B>> sharded_;
  LinearizationAdaptor<B> adaptor_;
  LinearizationAdaptor<B>* batch_ = &adaptor_;
  ColumnScale<B> scale_;
  typename B::Vector rhs_, metric_, mask_, diagonal_;
  std::optional<PcgStep<B>> inner_;
};

// y = M^-1 x, where M consists of the diagonal blocks of the Schur complement.
template <Backend B>
class SchurJacobi final : public LinearOperator<B> {
 public:
  explicit SchurJacobi(ReducedSystem<B>& reduced) : blocks_(reduced.size(), reduced.kept_groups()) {}
  void Update(ReducedSystem<B>& reduced) {
    reduced.DiagonalBlocks(blocks_);
    blocks_.Factorize();
  }
  Index size() const override { return blocks_.num_parameters(); }
  void Apply(typename B::ConstVectorView x, typename B::VectorView y) override { blocks_.Solve(x, y); }

 private:
  BlockDiagonal<B> blocks_;
};

// PCG on the Schur complement of a group of parameters (ReducedSystem).
template <Backend B>
class ReducedPcgStep final : public StepSolver<B> {
 public:
  ReducedPcgStep(const NormalSystemOptions& options, const StepSystem<B>& system,
                 std::unique_ptr<ReducedSystem<B>> reduced)
      : options_(options), system_(system), reduced_(std::move(reduced)), reduced_rhs_(reduced_->size()) {
    const PreconditionerKind kind = options.preconditioner;
    const bool always = kind == PreconditionerKind::kSparseCholesky;
    if (always || kind == PreconditionerKind::kAuto || kind == PreconditionerKind::kProblem) {
      factorize_ = reduced_->PlanFactor(always);
    }
    if (always && !factorize_) {
      Fail(kUnsupported,
           "preconditioner = {}: this problem has no factor of its reduced system, or a too slow one; choose kAuto",
           ToString(kind));
    }
    preconditioner_ = kind == PreconditionerKind::kIdentity ? ToString(kind)
                      : factorize_                          ? reduced_->factor_description()
                                                            : "Schur-Jacobi";
    // As in PcgStep: one iteration is enough if the factor is exact, as usual.
    if (factorize_ && options_.pcg.relative_tolerance == 0) options_.pcg.relative_tolerance = kExactTolerance;
    if (!factorize_ && kind != PreconditionerKind::kIdentity) schur_jacobi_.emplace(*reduced_);
  }
  const std::string& preconditioner() const { return preconditioner_; }
  StepSolution Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step) override {
    const Index kept = reduced_->size();
    IdentityPreconditioner<B> identity(kept);
    LinearOperator<B>* preconditioner = &identity;
    {
      ScopedPhase phase("elimination");
      reduced_->SetDamping(lambda, system_.metric);
      reduced_->ReduceRhs(system_.rhs, reduced_rhs_);
      phase.Next("preconditioner");
      if (factorize_) {
        preconditioner = reduced_->Factorize();
      } else if (schur_jacobi_) {
        schur_jacobi_->Update(*reduced_);
        preconditioner = &*schur_jacobi_;
      }
    }
    const auto kept_step = step.subspan(0, kept);
    const auto& weights = system_.scale.square;
    const PcgSummary pcg =
        SolvePcg<B>(options_.pcg, system_.backend, *reduced_, reduced_rhs_, *preconditioner, workspace, kept_step,
                    weights.empty() ? weights.view() : weights.view().subspan(0, kept));
    reduced_->BackSubstitute(system_.rhs, step);
    // The residual is zero in the eliminated rows, and equals the residual of the reduced system in the other rows.
    return FromResidual(system_, pcg, lambda, system_.backend.Dot(workspace.residual(), kept_step), step);
  }

 private:
  NormalSystemOptions options_;
  StepSystem<B> system_;
  std::unique_ptr<ReducedSystem<B>> reduced_;
  bool factorize_ = false;
  std::string preconditioner_;
  std::optional<SchurJacobi<B>> schur_jacobi_;
  typename B::Vector reduced_rhs_;
};

}  // namespace vesta::step_internal
