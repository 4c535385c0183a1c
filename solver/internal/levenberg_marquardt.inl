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
#include "solver/internal/trust_region/step_control.h"
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
    : options_(options),
      backend_(backend),
      problem_(problem),
      nonmonotonic_(options.step_control.max_consecutive_nonmonotonic_steps),
      start_(std::chrono::steady_clock::now()) {
  options_.Validate();
  VESTA_CHECK(problem_.num_batches() >= 1, "num_batches() is {}; it must be 1 or more", problem_.num_batches());
  control_.emplace(options_.step_control);
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
      options_.line_search.enabled ? ", line search" : "", nonmonotonic_.enabled() ? ", nonmonotonic steps" : "");
  const ProfileScope timed = Timed();
  LmIteration row;
  summary_.fixed_cost = problem_.FixedCost(x_);
  initial_cost_ = cost_ = FullCost(x_);
  nonmonotonic_.Start(cost_);
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
double LmStepper<B>::DoubtfulGain() const {
  const double rounding = sizeof(typename B::Scalar) == sizeof(double) ? 1e-9 : 1e-4;
  return std::max(std::max(10 * options_.function_tolerance, rounding) * cost_, 1e-20 * initial_cost_);
}

template <Backend B>
void LmStepper<B>::StopConverged(LmStatus status, std::string message, const std::string& doubt) {
  if (!doubt.empty())
    return Stop(LmStatus::kNoDecrease, "no step decreases the cost as predicted, however short" + doubt);
  if (zero_column_gradient_.empty()) return Stop(status, std::move(message));
  Stop(LmStatus::kGradientInZeroColumn, zero_column_gradient_);
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
  // If steps have another size than x, or there are bounds, measure the gradient by how far it moves x.
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
  system_ = std::make_unique<BatchedSystem<B>>(options_, backend_, problem_, x_.view(), cost_, scale_, summary_);
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
typename LmStepper<B>::Trial LmStepper<B>::Try(double gamma, const typename BatchedSystem<B>::Direction& direction,
                                               LmIteration& row) {
  MakeTrial(gamma);
  Trial trial{.cost = FullCost(trial_x_), .predicted = direction.Predicted(gamma)};
  const double change = cost_ - trial.cost;
  // rho has the sign of the change of cost, whatever the model predicts.
  trial.rho = trial.predicted == 0 && change == 0 ? 0 : change / std::abs(trial.predicted);
  // A model that predicts no decrease cannot be trusted, even if the cost decreased.
  if (trial.predicted > 0) trial.rho = nonmonotonic_.GainRatio(trial.rho, trial.cost, trial.predicted);
  trial.accepted = std::isfinite(trial.cost) && trial.predicted > 0 && control_->Accepts(trial.rho);
  trial.zone = ZoneOf(trial);
  row.gamma = gamma;
  row.cost_change = change;
  row.rho = trial.rho;
  row.step_norm = std::sqrt(backend_.Dot(scaled_step_, scaled_step_));
  return trial;
}

template <Backend B>
typename LmStepper<B>::Zone LmStepper<B>::ZoneOf(const Trial& trial) const {
  constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon(), kDoubt = 1e-9;
  const auto within = [&](double share) {
    return options_.function_tolerance < share && trial.predicted <= share * cost_ &&
           std::abs(cost_ - trial.cost) <= share * cost_;
  };
  // Never accept by gradient a cost above the start's. At bounds, only entries that are free to move count.
  if (!(trial.predicted > 0) || !(trial.cost <= initial_cost_)) return Zone::kCost;
  if (within(kRounding)) return Zone::kRounding;
  return within(kDoubt) && !trial.accepted ? Zone::kDoubtful : Zone::kCost;
}

template <Backend B>
void LmStepper<B>::AcceptByGradient(Trial& trial) {
  std::unique_ptr<BatchedSystem<B>> at_trial;
  {
    const lm_internal::Stopwatch watch(summary_.linearize_seconds, "LM linearise");
    at_trial =
        std::make_unique<BatchedSystem<B>>(options_, backend_, problem_, trial_x_.view(), trial.cost, scale_, summary_);
  }
  const auto squared = [&](const BatchedSystem<B>& system) {
    backend_.DivideOrZero(system.negative_gradient(), system_->weights(), scaled_step_);
    return backend_.Dot(system.negative_gradient(), scaled_step_);
  };
  const double share = trial.zone == Zone::kDoubtful ? 0.5 : 1.0;
  trial.accepted = at_trial->fault().kind == SystemFault::Kind::kNone && squared(*at_trial) < share * squared(*system_);
  // Use a gain ratio of 1, because the true one is not measurable.
  if (trial.accepted) trial.rho = 1;
  if (!trial.accepted && trial.zone == Zone::kRounding)
    StopConverged(LmStatus::kFunctionTolerance, "cost and gradient have reached their rounding error",
                  doubt_.Describe(false, DoubtfulGain()));
}

template <Backend B>
const LmIteration& LmStepper<B>::Step() {
  if (done()) return summary_.iterations.back();
  const ProfileScope timed = Timed();
  LmIteration row;
  row.lambda = control_->lambda();
  row.gradient_max_norm = gradient_norm_;
  typename BatchedSystem<B>::Direction direction;
  {
    const lm_internal::Stopwatch watch(summary_.linear_solve_seconds, "LM solve");
    ShareTrialVectors();
    if (step_.empty()) step_.Resize(problem_.num_tangent());
    direction = system_->Solve(row.lambda, workspace_, step_);
    if (problem_.has_bounds()) {
      problem_.ClipStep(x_, step_);
      system_->Measure(step_, direction);
    }
    workspace_.r = {};  // trials reuse only the other two vectors
  }
  row.pcg_iterations = direction.pcg.iterations;
  row.pcg_status = direction.pcg.status;
  row.pcg_residual = direction.pcg.rhs_norm > 0 ? direction.pcg.residual_norm / direction.pcg.rhs_norm : 0;

  Trial trial = Try(ChooseGamma(), direction, row);
  if (trial.zone != Zone::kCost) AcceptByGradient(trial);
  row.accepted = trial.accepted;
  if (trial.accepted) {
    control_->OnAccept(trial.rho);
    system_.reset();  // was made for the previous x_
    if (nonmonotonic_.enabled()) {
      // The cost is not comparable where the gradient decides.
      const bool lowest =
          nonmonotonic_.OnAccept(trial.cost, trial.predicted) || (trial.zone != Zone::kCost && best_x_.empty());
      if (lowest) {
        best_x_ = {};
      } else if (best_x_.empty()) {
        best_x_ = std::move(x_);
      }
    }
    std::swap(x_, trial_x_);
    cost_ = trial.cost;
    ReportCosts();
    ++summary_.num_accepted;
    consecutive_rejects_ = 0;
  } else {
    ++summary_.num_rejected;
    ++consecutive_rejects_;
  }
  if (!done()) TestStep(row, trial);
  if (!trial.accepted) {
    if (!done() && control_->at_upper_bound()) {
      Stop(LmStatus::kNoDecrease, fmt::format("step rejected with lambda at its upper bound {:.3e}{}", row.lambda,
                                              doubt_.Describe(false, DoubtfulGain())));
    }
    control_->OnReject();
  } else {
    x_norm_ = problem_.VariableNorm(backend_, x_);
  }
  ReleaseVectors();
  // Test the limits first, because a linearization whose step is never taken is wasted.
  if (!done()) TestLimits();
  if (!done()) Linearize();
  return Record(row);
}

template <Backend B>
void LmStepper<B>::TestStep(const LmIteration& row, const Trial& trial) {
  const double change = std::abs(row.cost_change);
  const double before = row.accepted ? cost_ + row.cost_change : cost_;
  // A linear solver that failed before its first iteration says nothing about x.
  const bool solved = row.pcg_iterations > 0 || row.pcg_status == PcgStatus::kConverged;
  const bool by_gradient = trial.accepted && trial.zone != Zone::kCost;
  const double smallest = options_.parameter_tolerance * (x_norm_ + options_.parameter_tolerance);
  // Doubt from the steps before this one, then including this one.
  const std::string doubt_before = doubt_.Describe(trial.accepted, DoubtfulGain());
  if (!trial.accepted) doubt_.OnReject(trial.predicted, std::isfinite(trial.cost));
  const std::string doubt = doubt_.Describe(trial.accepted, DoubtfulGain());
  if (trial.accepted) doubt_.OnAccept();
  if (solved && row.step_norm <= smallest) {
    StopConverged(LmStatus::kParameterTolerance,
                  fmt::format("step {:.3e} <= tolerance {:.3e}", row.step_norm, smallest), doubt_before);
  } else if (solved && !by_gradient && change <= options_.function_tolerance * before) {
    StopConverged(LmStatus::kFunctionTolerance,
                  fmt::format("|change of cost| / cost = {:.3e} <= tolerance {:.3e}",
                              before > 0 ? change / before : 0.0, options_.function_tolerance),
                  doubt);
  } else if (consecutive_rejects_ >= options_.max_consecutive_rejects) {
    Stop(LmStatus::kNoDecrease, fmt::format("{} steps in a row were rejected{}", consecutive_rejects_, doubt));
  }
}

template <Backend B>
void LmStepper<B>::TestLimits() {
  const int iterations = summary_.num_accepted + summary_.num_rejected;
  if (iterations >= options_.max_iterations) {
    Stop(LmStatus::kMaxIterations, fmt::format("{} iterations{}", iterations, doubt_.DescribeIncrease(DoubtfulGain())));
  } else if (problem_.OnAnyProcess(Seconds() >= options_.max_seconds)) {
    Stop(LmStatus::kTimeLimit, fmt::format("{:.3f} s of {:.3f} s", Seconds(), options_.max_seconds));
  }
}

template <Backend B>
const LmIteration& LmStepper<B>::Record(LmIteration row) {
  row.iteration = static_cast<int>(summary_.iterations.size());
  row.cost = cost_ + summary_.fixed_cost;
  row.seconds = summary_.total_seconds = Seconds();
  summary_.iterations.push_back(row);
  if (options_.profile) summary_.phases = profile_.Rows();
  return summary_.iterations.back();
}

template <Backend B>
LmSummary SolveLm(const LmOptions& options, B& backend, Problem<B>& problem, typename B::VectorView x,
                  const LmCallback& callback) {
  LmStepper<B> stepper(options, backend, problem, x);
  const auto report = [&] {
    stepper.StopIfRequested(callback && callback(stepper.summary().iterations.back()) == CallbackResult::kStop);
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
