// SPDX-License-Identifier: Apache-2.0
#include "solver/ceres/ceres_solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "solver/ceres/ceres_problem.h"

namespace vesta::ceres_bridge {
namespace {

using B = CpuBackend<double>;
enum class Next { kContinue, kStop, kAbort };
// Called after the start and after each iteration.
using AfterIteration = std::function<Next(const LmStepper<B>& stepper)>;

bool UsesSparseCholesky(const ceres::Solver::Options& options) {
  return options.linear_solver_type == ceres::SPARSE_NORMAL_CHOLESKY;
}

// The summary of a solve that ends before the cost is evaluated.
LmSummary InvalidOptions(std::string message) {
  LmSummary summary;
  summary.status = LmStatus::kInvalidOptions;
  summary.message = std::move(message);
  summary.initial_cost = summary.final_cost = std::numeric_limits<double>::quiet_NaN();
  return summary;
}

LmSummary Run(const LmOptions& options, CeresProblem& bridge, std::vector<std::string> notes,
              const AfterIteration& after) {
  try {
    options.Validate();
  } catch (const Error& error) {
    return InvalidOptions(error.what());
  }
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
  if (!bridge.infeasible().empty()) {
    stepper.Stop(LmStatus::kInfeasible, bridge.infeasible());
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
  if (std::string message; !options.IsValid(&message)) return InvalidOptions(std::move(message));
  CeresProblem bridge(problem, {.dynamic_sparsity = options.dynamic_sparsity && UsesSparseCholesky(options)});
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

LmOptions FromCeres(const ceres::Solver::Options& from) {
  LmOptions options;
  options.max_iterations = from.max_num_iterations;
  options.max_seconds = from.max_solver_time_in_seconds;
  options.function_tolerance = from.function_tolerance;
  options.gradient_tolerance = from.gradient_tolerance;
  options.parameter_tolerance = from.parameter_tolerance;
  options.step_control.initial_lambda = 1 / from.initial_trust_region_radius;
  // Ceres accepts an infinite largest radius; lambda must be above 0.
  options.step_control.min_lambda = std::max(1 / from.max_trust_region_radius, std::numeric_limits<double>::min());
  options.step_control.max_lambda = 1 / from.min_trust_region_radius;
  options.step_control.min_relative_decrease = from.min_relative_decrease;
  if (from.use_nonmonotonic_steps) {
    options.step_control.max_consecutive_nonmonotonic_steps = from.max_consecutive_nonmonotonic_steps;
  }
  options.column_scaling = from.jacobi_scaling ? ColumnScaling::kOnePlusInverse : ColumnScaling::kNone;
  NormalSystemOptions& system = options.normal_system;
  system.metric.min_diagonal = from.min_lm_diagonal;
  system.metric.max_diagonal = from.max_lm_diagonal;
  system.pcg.max_iterations = from.max_linear_solver_iterations;
  system.pcg.min_iterations = from.min_linear_solver_iterations;
  system.pcg.model_tolerance = from.eta;
  switch (from.linear_solver_type) {
    case ceres::DENSE_QR:
    case ceres::DENSE_NORMAL_CHOLESKY:
      system.linear_solver = LinearSolverKind::kDenseQr;
      break;
    case ceres::CGNR:
      system.linear_solver = LinearSolverKind::kPcg;
      system.preconditioner = from.preconditioner_type == ceres::IDENTITY ? PreconditionerKind::kIdentity
                                                                          : PreconditionerKind::kBlockJacobi;
      break;
    case ceres::DENSE_SCHUR:
    case ceres::SPARSE_SCHUR:
    case ceres::SPARSE_NORMAL_CHOLESKY:
      system.linear_solver = UsesSparseCholesky(from) ? LinearSolverKind::kPcg : LinearSolverKind::kAuto;
      system.preconditioner = PreconditionerKind::kSparseCholesky;
      // Solve to rounding, like a direct solver. The second test ends solves whose rounding error exceeds the first.
      system.pcg.relative_tolerance = 1e-10;
      system.pcg.model_tolerance = 1e-4;
      break;
    default:
      system.linear_solver = LinearSolverKind::kAuto;
  }
  return options;
}

std::vector<std::string> IgnoredOptions(const ceres::Solver::Options& options) {
  using Options = ceres::Solver::Options;
  const Options defaults;
  std::vector<std::string> ignored;
  const auto note = [&](bool differs, const char* name, const char* instead) {
    if (differs) ignored.push_back(fmt::format("{} of ceres::Solver::Options is ignored: {}", name, instead));
  };
  const auto changed = [&](auto Options::*member, const char* name, const char* instead) {
    note(options.*member != defaults.*member, name, instead);
  };
  note(options.minimizer_type != ceres::TRUST_REGION, "minimizer_type = LINE_SEARCH",
       "the steps are Levenberg-Marquardt's");
  note(options.trust_region_strategy_type != ceres::LEVENBERG_MARQUARDT, "trust_region_strategy_type = DOGLEG",
       "the steps are Levenberg-Marquardt's");
  changed(&Options::use_inner_iterations, "use_inner_iterations", "they are not supported");
  changed(&Options::check_gradients, "check_gradients", "use solver/derivative_check.h in a test");
  changed(&Options::num_threads, "num_threads", "all cores are used; call vesta::SetNumThreads");
  changed(&Options::max_num_consecutive_invalid_steps, "max_num_consecutive_invalid_steps",
          "set max_consecutive_rejects in the result of FromCeres");
  changed(&Options::minimizer_progress_to_stdout, "minimizer_progress_to_stdout", "the library prints nothing");
  note(options.linear_solver_ordering != nullptr, "linear_solver_ordering",
       "the group to eliminate is found automatically");
  changed(&Options::use_explicit_schur_complement, "use_explicit_schur_complement",
          "DENSE_SCHUR and SPARSE_SCHUR form the Schur complement");
  const bool iterative =
      options.linear_solver_type == ceres::CGNR || options.linear_solver_type == ceres::ITERATIVE_SCHUR;
  note(iterative && options.preconditioner_type != ceres::IDENTITY && options.preconditioner_type != ceres::JACOBI &&
           options.preconditioner_type != ceres::SCHUR_JACOBI,
       "preconditioner_type", "block Jacobi, or Schur-Jacobi, is used");
  note(options.dynamic_sparsity && !UsesSparseCholesky(options), "dynamic_sparsity",
       "only SPARSE_NORMAL_CHOLESKY uses it");
  changed(&Options::use_mixed_precision_solves, "use_mixed_precision_solves", "all computations use double");
  changed(&Options::max_num_refinement_iterations, "max_num_refinement_iterations", "PCG refines by its own tests");
  note(!options.trust_region_minimizer_iterations_to_dump.empty(), "trust_region_minimizer_iterations_to_dump",
       "nothing is written");
  return ignored;
}

}  // namespace vesta::ceres_bridge
