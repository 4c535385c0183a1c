// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/internal/normal_equations/step_solver.h: solvers that use J itself, and the choice between
// these and conjugate gradients.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/profile.h"
#include "solver/internal/linear/dense_qr.h"
#include "solver/internal/linear/lsmr.inl"
#include "solver/internal/normal_equations/pcg_steps.h"
#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/internal/normal_equations/step_cost.h"
#include "solver/internal/normal_equations/step_solver.h"

namespace vesta {

namespace step_internal {

// Computes g^T step and step^T H step in residual space, for W = I and d = -g. This loses no digits to the condition
// number of H.
template <Backend B>
StepSolution FromResiduals(const StepSystem<B>& system, PcgSummary pcg, typename B::VectorView step) {
  StepSolution solution{.pcg = pcg};
  for (LinearizationAdaptor<B>* batch : system.batches) {
    typename B::Vector Js(batch->num_residuals());
    batch->ApplyJ(step, Js);
    solution.gradient_dot_step += system.backend.Dot(batch->residuals(), Js);
    solution.curvature += system.backend.Dot(Js.view(), Js.view());
  }
  return solution;
}

// The damped least-squares problem with columns of unit length: [J_1; J_2; ...; sqrt(lambda D)] P. Here P = diag(H +
// lambda D)^-1/2, with zeros for parameters that cannot change.
template <Backend B>
class StackedJacobian final : public LinearMap<B> {
 public:
  StackedJacobian(const StepSystem<B>& system, double lambda)
      : system_(system),
        root_damping_(system.metric.size()),
        scale_(system.metric.size()),
        work_(system.metric.size()) {
    B& backend = system.backend;
    backend.Axpby(lambda, system.metric, 0.0, work_);
    backend.Sqrt(work_, root_damping_);
    backend.Axpby(1.0, system.diagonal, 1.0, work_);
    backend.Sqrt(work_, work_);
    typename B::Vector one(system.metric.size());
    backend.Fill(1, one);
    backend.DivideOrZero(one, work_, scale_);
    if (!system.mask.empty()) backend.Multiply(system.mask, scale_, scale_);
    for (LinearizationAdaptor<B>* batch : system.batches) residual_rows_ += batch->num_residuals();
  }
  Index rows() const override { return residual_rows_ + cols(); }
  Index cols() const override { return root_damping_.size(); }
  typename B::ConstVectorView scale() const { return scale_.view(); }
  void Apply(typename B::ConstVectorView x, typename B::VectorView y) override {
    system_.backend.Multiply(scale_, x, work_);
    Index row = 0;
    for (LinearizationAdaptor<B>* batch : system_.batches) {
      batch->ApplyJ(work_, y.subspan(row, batch->num_residuals()));
      row += batch->num_residuals();
    }
    system_.backend.Multiply(root_damping_, work_, y.subspan(row, cols()));
  }
  void ApplyAdjoint(typename B::ConstVectorView y, typename B::VectorView x) override {
    system_.backend.Multiply(root_damping_, y.subspan(residual_rows_, cols()), x);
    Index row = 0;
    for (LinearizationAdaptor<B>* batch : system_.batches) {
      batch->ApplyJT(y.subspan(row, batch->num_residuals()), work_);
      system_.backend.Axpby(1.0, work_, 1.0, x);
      row += batch->num_residuals();
    }
    system_.backend.Multiply(scale_, x, x);
  }

 private:
  StepSystem<B> system_;
  Index residual_rows_ = 0;
  typename B::Vector root_damping_, scale_, work_;
};

template <Backend B>
class LsmrStep final : public StepSolver<B> {
 public:
  LsmrStep(const LsmrOptions& options, const StepSystem<B>& system) : options_(options), system_(system) {}
  bool reads_diagonal() const override { return true; }
  StepSolution Solve(double lambda, PcgWorkspace<B>&, typename B::VectorView step) override {
    B& backend = system_.backend;
    StackedJacobian<B> stacked(system_, lambda);
    typename B::Vector b(stacked.rows());
    Index row = 0;
    for (LinearizationAdaptor<B>* batch : system_.batches) {
      backend.Axpby(-1.0, batch->residuals(), 0.0, b.view().subspan(row, batch->num_residuals()));
      row += batch->num_residuals();
    }
    const LsmrSummary lsmr = SolveLsmr<B>(options_, backend, stacked, b, step);
    backend.Multiply(stacked.scale(), step, step);
    PcgSummary pcg{.iterations = lsmr.iterations,
                   .products = lsmr.iterations,
                   .rhs_norm = std::sqrt(backend.Dot(b.view(), b.view())),
                   .residual_norm = lsmr.normal_residual_norm};
    pcg.status = !lsmr.finite     ? PcgStatus::kNonFinite
                 : lsmr.converged ? PcgStatus::kConverged
                                  : PcgStatus::kMaxIterations;
    return FromResiduals(system_, pcg, step);
  }

 private:
  LsmrOptions options_;
  StepSystem<B> system_;
};

template <Backend B>
class DenseQrStep final : public StepSolver<B> {
 public:
  explicit DenseQrStep(const StepSystem<B>& system) : system_(system), qr_(DenseFactors(system)) {}
  StepSolution Solve(double lambda, PcgWorkspace<B>&, typename B::VectorView step) override {
    std::vector<double> solution(static_cast<std::size_t>(step.size()));
    ToHost(system_.backend, system_.metric, solution.data());
    for (double& damping : solution) damping *= lambda;
    qr_.Solve(solution);
    FromHost(system_.backend, solution.data(), step);
    PcgSummary pcg{.status = PcgStatus::kConverged};
    if (!system_.backend.AllFinite(step)) {
      pcg.status = PcgStatus::kNonFinite;
      system_.backend.Fill(0, step);
    } else if (!system_.mask.empty()) {
      system_.backend.Multiply(system_.mask, step, step);
    }
    return FromResiduals(system_, pcg, step);
  }

 private:
  static DenseQr DenseFactors(const StepSystem<B>& system) {
    const ScopedPhase phase("dense QR");
    DenseJacobian dense = MakeDenseJacobian(system.backend, system.batches, system.mask);
    return {dense.rows, dense.cols, std::move(dense.jacobian), std::move(dense.residuals)};
  }
  StepSystem<B> system_;
  DenseQr qr_;
};

// Returns null if J and the residuals define the step. Otherwise returns the reason why the normal equations are
// needed.
template <Backend B>
const char* ReasonForNormalEquations(const StepSystem<B>& system) {
  const auto any = [&](auto&& has) { return std::any_of(system.batches.begin(), system.batches.end(), has); };
  if (any([](auto* batch) { return batch->weighted(); })) return "the problem has weights W";
  if (any([](auto* batch) { return batch->has_own_right_hand_side(); }))
    return "the problem has its own right-hand side";
  return nullptr;
}

template <Backend B>
bool CanReduce(const StepSystem<B>& system) {
  return system.batches.size() == 1 && !system.problem.has_bounds();
}

// The choice of kAuto, and the reason. The reason is empty if no description is needed.
struct Choice {
  LinearSolverKind kind;
  bool factor = false;  // kPcg, preconditioned by the problem's sparse Cholesky factor
  std::string why;
};

// counts: null if the problem cannot provide its factor. reduced: set to the reduced system if the choice is
// kReducedPcg.
template <Backend B>
Choice Choose(const StepSystem<B>& system, const char* why_normal, const StepCounts* counts,
              std::unique_ptr<ReducedSystem<B>>& reduced, bool describe) {
  // Formatting takes a while, compared with a step of a small problem.
  const auto reason = [&](const auto& text) { return describe ? std::string(text()) : std::string(); };
  const Index n = system.metric.size();
  Index rows = 0;
  for (LinearizationAdaptor<B>* batch : system.batches) rows += batch->num_residuals();
  if (CanReduce(system)) {
    reduced = system.batches.front()->MakeReducedSystem();
    if (reduced) {
      return {LinearSolverKind::kReducedPcg, false, reason([&] {
                if (!counts || !counts->reduced)
                  return std::string("the problem has a block-diagonal group to eliminate");
                if (!FactorBeatsIterations(*counts)) return WhyNoFactor(*counts);
                return CompareFactorCost(*counts, DescribeIterations(*counts), IterationsCost(*counts));
              })};
    }
  }
  const auto shape = [&] { return fmt::format("a Jacobian of {} x {}", rows, n); };
  if (why_normal == nullptr && DenseQrFits(static_cast<double>(rows), static_cast<double>(n))) {
    if (counts && FactorBeatsDenseQr(*counts)) {
      return {LinearSolverKind::kPcg, true,
              reason([&] { return CompareFactorCost(*counts, "dense QR", DenseQrCost(*counts)); })};
    }
    return {LinearSolverKind::kDenseQr, false, reason(shape)};
  }
  return {LinearSolverKind::kPcg, false, reason([&] { return why_normal != nullptr ? why_normal : shape(); })};
}

}  // namespace step_internal

template <Backend B>
std::unique_ptr<StepSolver<B>> MakeStepSolver(const NormalSystemOptions& options, const StepSystem<B>& system,
                                              bool describe) {
  const char* const why_normal = step_internal::ReasonForNormalEquations(system);
  std::unique_ptr<ReducedSystem<B>> reduced;
  const bool asked_reduced = options.linear_solver == LinearSolverKind::kReducedPcg;
  if (asked_reduced && step_internal::CanReduce(system)) reduced = system.batches.front()->MakeReducedSystem();
  LinearSolverKind kind = options.linear_solver;
  PreconditionerKind preconditioner = options.preconditioner;
  std::string why;
  if (kind == LinearSolverKind::kAuto) {
    const bool may_factorize =
        preconditioner == PreconditionerKind::kAuto || preconditioner == PreconditionerKind::kProblem;
    const StepCounts* const counts =
        may_factorize ? system.problem.CountSteps(step_internal::CanReduce(system)) : nullptr;
    const step_internal::Choice choice = step_internal::Choose(system, why_normal, counts, reduced, describe);
    kind = choice.kind;
    if (choice.factor) preconditioner = PreconditionerKind::kSparseCholesky;
    if (describe) why = fmt::format(" (auto: {})", choice.why);
  }
  if (why_normal != nullptr && (kind == LinearSolverKind::kLsmr || kind == LinearSolverKind::kDenseQr)) {
    Fail(kUnsupported, "linear_solver = {} is not supported, because {}; choose PCG", ToString(kind), why_normal);
  }
  if (asked_reduced && !reduced) {
    Fail(kUnsupported,
         "linear_solver = {} needs a problem with one batch, no bounds and a group to eliminate; choose PCG",
         ToString(kind));
  }
  std::unique_ptr<StepSolver<B>> solver;
  std::string preconditioner_name;
  switch (kind) {
    case LinearSolverKind::kReducedPcg: {
      auto pcg = std::make_unique<step_internal::ReducedPcgStep<B>>(options, system, std::move(reduced));
      if (describe) preconditioner_name = ", " + pcg->preconditioner();
      solver = std::move(pcg);
      break;
    }
    case LinearSolverKind::kLsmr:
      solver = std::make_unique<step_internal::LsmrStep<B>>(options.lsmr, system);
      break;
    case LinearSolverKind::kDenseQr:
      solver = std::make_unique<step_internal::DenseQrStep<B>>(system);
      break;
    default: {
      NormalSystemOptions chosen = options;
      chosen.preconditioner = preconditioner;
      const auto take = [&](auto pcg) {
        if (describe) preconditioner_name = ", " + pcg->preconditioner();
        solver = std::move(pcg);
      };
      auto sharded = system.batches.size() == 1 ? system.batches.front()->MakeShardedSystem() : nullptr;
      if (sharded) {
        take(std::make_unique<step_internal::ShardedPcgStep<B>>(chosen, system, std::move(sharded)));
      } else {
        take(std::make_unique<step_internal::PcgStep<B>>(chosen, system));
      }
    }
  }
  if (describe) solver->set_description(ToString(kind) + preconditioner_name + why);
  return solver;
}

}  // namespace vesta
