// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/levenberg_marquardt.h.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/profile.h"
#include "solver/check_problem.h"
#include "solver/internal/batched_system.inl"
#include "solver/levenberg_marquardt.h"

namespace vesta {

namespace lm_internal {
// Measures a phase of the profile, and adds its time to a total.
class Stopwatch {
 public:
  Stopwatch(double& total, const char* phase)
      : phase_(phase), total_(total), start_(std::chrono::steady_clock::now()) {}
  ~Stopwatch() { total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  ScopedPhase phase_;
  double& total_;
  std::chrono::steady_clock::time_point start_;
};
}  // namespace lm_internal

template <Backend B>
LmStepper<B>::LmStepper(const LmOptions& options, B& backend, Problem<B>& problem)
    : options_(options), backend_(backend), problem_(problem), start_(std::chrono::steady_clock::now()) {
  options_.Validate();
  VESTA_CHECK(problem_.num_batches() >= 1, "num_batches() is {}; it must be 1 or more", problem_.num_batches());
  decisions_.emplace(options_, CostRounding<typename B::Scalar>());
}

template <Backend B>
LmStepper<B>::LmStepper(const LmOptions& options, B& backend, Problem<B>& problem, ArchiveReader& saved)
    : LmStepper(options, backend, problem) {
  const ProfileScope timed = Timed();
  Visit(saved);
  VESTA_CHECK(x_.size() == problem.num_parameters() && !summary_.iterations.empty(),
              "the saved solve has {} parameters, but the problem has {}", x_.size(), problem.num_parameters());
  start_ -= std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(summary_.total_seconds));
  summary_.fixed_cost = problem_.FixedCost(x_);
  summary_.linear_solver.clear();  // the options may have changed
  ReportCosts();
  x_norm_ = problem_.VariableNorm(backend_, x_);
  // Linearize again at x_, with the same turn as before the solve was saved.
  --turn_;
  summary_.status = LmStatus::kRunning;
  TestLimits();
  if (!done()) Linearize();
}

template <Backend B>
LmStepper<B>::LmStepper(const LmOptions& options, B& backend, Problem<B>& problem, typename B::Vector&& x)
    : LmStepper(options, backend, problem) {
  x_ = std::move(x);
  if (x_.size() != problem_.num_parameters()) {
    Fail(kBadArgument, "x has {} entries, but the problem has {} parameters; give x one entry per parameter", x_.size(),
         problem_.num_parameters());
  }
  x_norm_ = problem_.VariableNorm(backend_, x_);
  summary_.num_parameters = problem_.num_parameters();
  summary_.num_tangent = problem_.num_tangent();
  summary_.num_batches = problem_.num_batches();
  summary_.configuration = fmt::format(
      "{} step rule, {}{}{}", ToString(options_.step_rule), ToString(options_.batch_mode),
      options_.line_search.enabled ? ", line search" : "", decisions_->is_nonmonotonic() ? ", nonmonotonic steps" : "");
  const ProfileScope timed = Timed();
  LmIteration row;
  summary_.fixed_cost = problem_.FixedCost(x_);
  decisions_->Start(FullCost(x_));
  ReportCosts();
  if (!std::isfinite(cost())) {
    const std::string where = problem_.DescribeNonFinite(x_, false);
    Stop(LmStatus::kNonFinite,
         fmt::format("the cost at the start is {}{}{}", cost(), where.empty() ? "" : ": ", where));
  } else if (problem_.has_bounds() && !problem_.IsFeasible(x_)) {
    const std::string where = problem_.DescribeInfeasible(x_);
    Stop(LmStatus::kInfeasible,
         fmt::format("the start violates a bound{}{}; move it inside", where.empty() ? "" : ": ", where));
  } else if (problem_.num_tangent() == 0) {
    Stop(LmStatus::kGradientTolerance, "the problem has no free parameters");
  } else if (const std::string why = problem_.DescribeDegenerate(x_); !why.empty()) {
    Stop(LmStatus::kDegenerateStart, why);
  } else if (PassesCheck() && Linearize()) {
    TestLimits();
  }
  row.gradient_max_norm = gradient_norm_;
  Record(row);
}

template <Backend B>
double LmStepper<B>::Seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

template <Backend B>
void LmStepper<B>::Stop(LmStatus status, std::string message) {
  summary_.status = status;
  summary_.message = std::move(message);
  summary_.total_seconds = Seconds();
}

template <Backend B>
void LmStepper<B>::StopIfRequested(bool requested) {
  if (problem_.OnAnyProcess(requested) && !done()) Stop(LmStatus::kStoppedByCallback, "the callback asked to stop");
}

template <Backend B>
void LmStepper<B>::StopConverged(LmStatus status, std::string message) {
  if (zero_column_gradient_.empty()) return Stop(status, std::move(message));
  Stop(LmStatus::kGradientInZeroColumn, zero_column_gradient_);
}

template <Backend B>
void LmStepper<B>::StopBy(const LmVerdict& verdict, double lambda) {
  using Reason = LmVerdict::Reason;
  const std::string doubt = verdict.doubt.Describe();
  std::string message;
  switch (verdict.reason) {
    case Reason::kNone:
      return;
    case Reason::kRejections:
      return Stop(verdict.status(), fmt::format("{} steps in a row were rejected{}", verdict.value, doubt));
    case Reason::kUpperBound:
      return Stop(verdict.status(),
                  fmt::format("step rejected with lambda at its upper bound {:.3e}{}", lambda, doubt));
    case Reason::kRoundingError:
      message = "cost and gradient have reached their rounding error";
      break;
    case Reason::kShortStep:
      message = fmt::format("step {:.3e} <= tolerance {:.3e}", verdict.value, verdict.limit);
      break;
    case Reason::kSmallChange:
      message = fmt::format("|change of cost| / cost = {:.3e} <= tolerance {:.3e}", verdict.value, verdict.limit);
      break;
  }
  if (IsConverged(verdict.status())) return StopConverged(verdict.status(), std::move(message));
  Stop(verdict.status(), "no step decreases the cost as predicted, however short" + doubt);
}

template <Backend B>
bool LmStepper<B>::PassesCheck() {
  if (!options_.check_derivatives) return true;
  const ProblemCheck check = CheckProblem<B>(backend_, problem_.get(), x_);
  if (check.ok()) return true;
  Stop(LmStatus::kCheckFailed, check.faults.size() == 1 ? check.faults.front()
                                                        : fmt::format("{} (and {} more faults: call CheckProblem)",
                                                                      check.faults.front(), check.faults.size() - 1));
  return false;
}

template <Backend B>
double LmStepper<B>::FullCost(typename B::ConstVectorView x) {
  const lm_internal::Stopwatch watch(summary_.cost_seconds, "LM cost");
  ++summary_.num_cost_evaluations;
  return problem_.VariableCost(x);
}

template <Backend B>
double LmStepper<B>::GradientNorm() {
  // If a step has another size than x, or there are bounds, measure how far a step -g moves x.
  if (problem_.num_tangent() == problem_.num_parameters() && !problem_.has_bounds())
    return backend_.MaxAbs(system_->negative_gradient());
  AcquireTrialVectors();
  problem_.Plus(backend_, x_, system_->negative_gradient(), trial_x_);
  return problem_.VariableMaxChange(backend_, x_, trial_x_);
}

template <Backend B>
bool LmStepper<B>::Linearize() {
  if (system_) return true;
  const lm_internal::Stopwatch watch(summary_.linearize_seconds, "LM linearise");
  problem_.OnNewPoint(turn_++);
  system_ =
      std::make_unique<BatchedSystem<B>>(options_, backend_, problem_, x_.view(), decisions_->cost(), scale_, summary_);
  zero_column_gradient_ = system_->zero_column_gradient();
  if (const SystemFault& fault = system_->fault(); fault.kind != SystemFault::Kind::kNone) {
    if (fault.kind == SystemFault::Kind::kDiagonal) {
      Stop(LmStatus::kBadDiagonal, fault.message);
    } else {
      const std::string where = problem_.DescribeNonFinite(x_, true);
      Stop(LmStatus::kNonFinite, where.empty() ? fault.message : "the derivatives are not finite: " + where);
    }
    return false;
  }
  gradient_norm_ = GradientNorm();
  if (gradient_norm_ <= options_.gradient_tolerance) {
    StopConverged(LmStatus::kGradientTolerance,
                  fmt::format("gradient {:.3e} <= tolerance {:.3e}", gradient_norm_, options_.gradient_tolerance));
    return false;
  }
  return true;
}

template <Backend B>
void LmStepper<B>::AcquireTrialVectors() {
  const auto take = [](typename B::Vector& lent, Index size, typename B::Vector& vector) {
    if (vector.empty() && lent.capacity() >= size) std::swap(vector, lent);
    if (vector.size() != size) vector.Resize(size);
  };
  take(workspace_.w, problem_.num_parameters(), trial_x_);
  take(workspace_.p, problem_.num_tangent(), scaled_step_);
}

template <Backend B>
void LmStepper<B>::ShareTrialVectors() {
  if (workspace_.w.empty()) std::swap(workspace_.w, trial_x_);
  if (workspace_.p.empty()) std::swap(workspace_.p, scaled_step_);
}

template <Backend B>
void LmStepper<B>::ReleaseVectors() {
  trial_x_ = {}, scaled_step_ = {}, step_ = {};
  workspace_.Release();
}

template <Backend B>
void LmStepper<B>::MakeTrial(double gamma) {
  AcquireTrialVectors();
  backend_.Axpby(gamma, step_, 0.0, scaled_step_);
  problem_.Plus(backend_, x_, scaled_step_, trial_x_);
}

template <Backend B>
double LmStepper<B>::ChooseGamma() {
  if (!options_.line_search.enabled) return 1;
  const Index turn = static_cast<Index>(summary_.iterations.size());
  const std::vector<Index> units = SpreadUnits(problem_.num_units(), options_.line_search.unit_fraction, turn);
  const lm_internal::Stopwatch watch(summary_.cost_seconds, "LM cost");
  const LineSearchResult result = SearchGamma(options_.line_search, [&](double gamma) {
    MakeTrial(gamma);
    return problem_.Cost(trial_x_, units);
  });
  summary_.num_subset_evaluations += result.evaluations;
  return result.gamma;
}

template <Backend B>
LmTrial LmStepper<B>::Try(double gamma, const typename BatchedSystem<B>::Direction& direction, LmIteration& row) {
  MakeTrial(gamma);
  const LmTrial trial = decisions_->Judge(FullCost(trial_x_), direction.Predicted(gamma));
  row.gamma = gamma;
  row.cost_change = trial.change;
  row.rho = trial.rho;
  row.step_norm = std::sqrt(backend_.Dot(scaled_step_, scaled_step_));
  return trial;
}

template <Backend B>
void LmStepper<B>::DecideByGradient(LmTrial& trial) {
  std::unique_ptr<BatchedSystem<B>> at_trial;
  {
    const lm_internal::Stopwatch watch(summary_.linearize_seconds, "LM linearise");
    at_trial =
        std::make_unique<BatchedSystem<B>>(options_, backend_, problem_, trial_x_.view(), trial.cost, scale_, summary_);
  }
  const bool finite = at_trial->fault().kind == SystemFault::Kind::kNone;
  const auto squared = [&](const BatchedSystem<B>& system) {
    backend_.DivideOrZero(system.negative_gradient(), system_->weights(), scaled_step_);
    return backend_.Dot(system.negative_gradient(), scaled_step_);
  };
  trial.DecideByGradient(finite, finite ? squared(*at_trial) : 0, finite ? squared(*system_) : 0);
}

template <Backend B>
const LmIteration& LmStepper<B>::Step() {
  if (done()) return summary_.iterations.back();
  const ProfileScope timed = Timed();
  LmIteration row;
  row.lambda = decisions_->lambda();
  row.gradient_max_norm = gradient_norm_;
  typename BatchedSystem<B>::Direction direction;
  bool is_clipped = false;
  {
    const lm_internal::Stopwatch watch(summary_.linear_solve_seconds, "LM solve");
    ShareTrialVectors();
    if (step_.empty()) step_.Resize(problem_.num_tangent());
    direction = system_->Solve(row.lambda, workspace_, step_);
    if (problem_.has_bounds()) {
      const double squared_norm = backend_.Dot(step_, step_);
      problem_.ClipStep(x_, step_);
      system_->Measure(step_, direction);
      is_clipped = backend_.Dot(step_, step_) != squared_norm;
    }
    workspace_.r = {};  // trials reuse only the other two vectors
  }
  row.pcg_iterations = direction.pcg.iterations;
  row.pcg_status = direction.pcg.status;
  row.pcg_residual = direction.pcg.rhs_norm > 0 ? direction.pcg.residual_norm / direction.pcg.rhs_norm : 0;

  LmTrial trial = Try(ChooseGamma(), direction, row);
  if (trial.zone != LmTrial::Zone::kCost) DecideByGradient(trial);
  trial.is_clipped = is_clipped;
  row.accepted = trial.accepted;
  // A linear solver that failed before its first iteration says nothing about x.
  const bool solved = row.pcg_iterations > 0 || row.pcg_status == PcgStatus::kConverged;
  StopBy(decisions_->Finish(trial, row.step_norm, x_norm_, solved), row.lambda);
  if (trial.accepted) {
    system_.reset();  // was made for the previous x_
    // If the gradient decides, costs differ only by rounding errors.
    if (decisions_->at_lowest_cost() || (trial.zone != LmTrial::Zone::kCost && best_x_.empty())) {
      best_x_ = {};
    } else if (best_x_.empty()) {
      best_x_ = std::move(x_);
    }
    std::swap(x_, trial_x_);
    ReportCosts();
    ++summary_.num_accepted;
    x_norm_ = problem_.VariableNorm(backend_, x_);
  } else {
    ++summary_.num_rejected;
  }
  ReleaseVectors();
  // Test the limits first, because a linearization whose step is never taken is wasted.
  if (!done()) TestLimits();
  if (!done()) Linearize();
  return Record(row);
}

template <Backend B>
void LmStepper<B>::TestLimits() {
  const int iterations = summary_.num_accepted + summary_.num_rejected;
  if (iterations >= options_.max_iterations) {
    Stop(LmStatus::kMaxIterations, fmt::format("{} iterations{}", iterations, decisions_->AtLimit().Describe()));
  } else if (problem_.OnAnyProcess(Seconds() >= options_.max_seconds)) {
    Stop(LmStatus::kTimeLimit, fmt::format("{:.3f} s of {:.3f} s", Seconds(), options_.max_seconds));
  }
}

template <Backend B>
const LmIteration& LmStepper<B>::Record(LmIteration row) {
  row.iteration = static_cast<int>(summary_.iterations.size());
  row.cost = decisions_->cost() + summary_.fixed_cost;
  row.seconds = summary_.total_seconds = Seconds();
  summary_.iterations.push_back(row);
  if (options_.profile) summary_.phases = profile_.Rows();
  return summary_.iterations.back();
}

template <Backend B>
LmSummary SolveLm(const LmOptions& options, B& backend, Problem<B>& problem, typename B::VectorView x,
                  const std::type_identity_t<IterationCallback<B>>& callback) {
  LmStepper<B> stepper(options, backend, problem, x);
  const auto report = [&] {
    stepper.StopIfRequested(callback(stepper.summary().iterations.back(), stepper.x()) == CallbackResult::kStop);
  };
  report();
  while (!stepper.done()) {
    stepper.Step();
    report();
  }
  backend.Copy(stepper.x(), x);
  return stepper.summary();
}

}  // namespace vesta
