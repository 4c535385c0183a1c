// SPDX-License-Identifier: Apache-2.0
#include "solver/ceres/ceres_solve.h"

#include <cmath>
#include <functional>
#include <utility>

#include "solver/ceres/ceres_problem.h"

namespace vesta::ceres_bridge {
namespace {

using B = CpuBackend<double>;
enum class Next { kContinue, kStop, kAbort };
// Called after the start and after each iteration.
using AfterIteration = std::function<Next(const LmStepper<B>& stepper)>;

LmSummary Run(const LmOptions& options, CeresProblem& bridge, std::vector<std::string> notes,
              const AfterIteration& after) {
  B backend;
  BlockProblem& problem = bridge.problem();
  B::Vector x = bridge.Gather();
  if (problem.has_bounds() && !problem.IsFeasible(x)) {
    B::Vector projected(x.size());
    problem.Plus(backend, x, B::Vector(problem.num_tangent()), projected);
    x = std::move(projected);
    notes.emplace_back("the start violated a bound; it was projected onto the bounds, as Ceres does");
  }
  LmStepper<B> stepper(options, backend, problem, x.view());
  Next next = Next::kContinue;
  const auto report = [&] {
    next = after(stepper);
    if (next != Next::kContinue && !stepper.done()) {
      stepper.Stop(LmStatus::kStoppedByCallback,
                   next == Next::kStop ? "a callback asked to stop" : "a callback aborted");
    }
  };
  if (!bridge.infeasible_constant().empty()) {
    stepper.Stop(LmStatus::kInfeasible, bridge.infeasible_constant());
  } else {
    report();
  }
  while (!stepper.done()) {
    stepper.Step();
    report();
  }
  if (next != Next::kAbort && stepper.summary().status != LmStatus::kInfeasible) bridge.Scatter(stepper.x());
  LmSummary summary = stepper.summary();
  summary.notes = std::move(notes);
  return summary;
}

Next Call(const LmCallback& callback, const LmIteration& row) {
  return callback && callback(row) == CallbackResult::kStop ? Next::kStop : Next::kContinue;
}

ceres::IterationSummary ToCeres(const LmStepper<B>& stepper, double eta) {
  const std::vector<LmIteration>& rows = stepper.summary().iterations;
  const LmIteration& row = rows.back();
  ceres::IterationSummary to;
  to.iteration = row.iteration;
  to.step_is_valid = row.iteration == 0 || std::isfinite(row.cost_change);
  to.step_is_successful = row.iteration == 0 || row.accepted;
  to.cost = row.cost;
  to.cost_change = row.cost_change;
  to.gradient_max_norm = row.gradient_max_norm;
  to.step_norm = row.step_norm;
  to.relative_decrease = row.rho;
  to.trust_region_radius = 1 / stepper.lambda();
  to.eta = eta;
  to.linear_solver_iterations = row.pcg_iterations;
  to.iteration_time_in_seconds = row.seconds - (row.iteration == 0 ? 0 : rows[rows.size() - 2].seconds);
  to.cumulative_time_in_seconds = row.seconds;
  return to;
}

}  // namespace

LmSummary Solve(const LmOptions& options, ceres::Problem& problem, const LmCallback& callback) {
  CeresProblem bridge(problem);
  return Run(options, bridge, {},
             [&](const LmStepper<B>& stepper) { return Call(callback, stepper.summary().iterations.back()); });
}

LmSummary Solve(const ceres::Solver::Options& options, ceres::Problem& problem, const LmCallback& callback,
                ceres::EvaluationCallback* evaluation_callback) {
  CeresProblem bridge(problem);
  bridge.SetEvaluationCallback(evaluation_callback);
  const auto after = [&](const LmStepper<B>& stepper) {
    const LmIteration& row = stepper.summary().iterations.back();
    if (options.update_state_every_iteration) bridge.Scatter(stepper.x());
    if (!options.callbacks.empty()) {
      const ceres::IterationSummary summary = ToCeres(stepper, options.eta);
      for (ceres::IterationCallback* one : options.callbacks) {
        const ceres::CallbackReturnType result = (*one)(summary);
        if (result == ceres::SOLVER_ABORT) return Next::kAbort;
        if (result == ceres::SOLVER_TERMINATE_SUCCESSFULLY) return Next::kStop;
      }
    }
    return Call(callback, row);
  };
  return Run(FromCeres(options), bridge, IgnoredOptions(options), after);
}

}  // namespace vesta::ceres_bridge
