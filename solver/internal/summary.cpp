// SPDX-License-Identifier: Apache-2.0
#include "solver/summary.h"

#include <fmt/format.h>

#include <iterator>

namespace vesta {

const char* ToString(LmStatus status) {
  switch (status) {
    case LmStatus::kRunning:
      return "running";
    case LmStatus::kFunctionTolerance:
      return "converged (function tolerance)";
    case LmStatus::kGradientTolerance:
      return "converged (gradient tolerance)";
    case LmStatus::kParameterTolerance:
      return "converged (parameter tolerance)";
    case LmStatus::kMaxIterations:
      return "stopped (iteration limit)";
    case LmStatus::kTimeLimit:
      return "stopped (time limit)";
    case LmStatus::kStoppedByCallback:
      return "stopped (callback)";
    case LmStatus::kNoDecrease:
      return "stopped (no decrease found)";
    case LmStatus::kInfeasible:
      return "failed (start violates a bound)";
    case LmStatus::kNonFinite:
      return "failed (not finite)";
    case LmStatus::kBadDiagonal:
      return "failed (invalid diagonal of H)";
    case LmStatus::kGradientInZeroColumn:
      return "failed (a zero column has a gradient)";
    case LmStatus::kDegenerateStart:
      return "failed (degenerate start)";
    case LmStatus::kCheckFailed:
      return "failed (CheckProblem found a fault)";
    case LmStatus::kInvalidOptions:
      return "failed (invalid options)";
  }
  return "unknown";
}

bool IsConverged(LmStatus status) {
  return status == LmStatus::kFunctionTolerance || status == LmStatus::kGradientTolerance ||
         status == LmStatus::kParameterTolerance;
}

bool IsFailure(LmStatus status) {
  return status == LmStatus::kInfeasible || status == LmStatus::kNonFinite || status == LmStatus::kBadDiagonal ||
         status == LmStatus::kGradientInZeroColumn || status == LmStatus::kDegenerateStart ||
         status == LmStatus::kCheckFailed || status == LmStatus::kInvalidOptions;
}

std::string LmSummary::BriefReport() const {
  return fmt::format("{}: cost {:.6e} -> {:.6e}, {} iterations ({} accepted), {} PCG iterations, {:.3f} s",
                     ToString(status), initial_cost, final_cost, num_accepted + num_rejected, num_accepted,
                     num_pcg_iterations, total_seconds);
}

std::string LmSummary::FullReport() const {
  std::string text;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "Levenberg-Marquardt: {}\n{}\n", ToString(status), message);
  for (const std::string& note : notes) fmt::format_to(out, "note: {}\n", note);
  text += '\n';
  fmt::format_to(out, "parameters        {:>12}   tangent {}, zero columns {}\n", num_parameters, num_tangent,
                 num_zero_columns);
  fmt::format_to(out, "residuals         {:>12}   in {} batches\n", num_residuals, num_batches);
  fmt::format_to(out, "linear solver     {}\n", linear_solver);
  fmt::format_to(out, "parts             {}\n", configuration);
  fmt::format_to(out, "cost              {:.12e} -> {:.12e}\n", initial_cost, final_cost);
  if (fixed_cost != 0) fmt::format_to(out, "fixed cost        {:.12e}\n", fixed_cost);
  fmt::format_to(out, "iterations        {:>12}   accepted {}, rejected {}\n", num_accepted + num_rejected,
                 num_accepted, num_rejected);
  fmt::format_to(out, "PCG iterations    {:>12}   products {}\n", num_pcg_iterations, num_products);
  fmt::format_to(out, "linearizations    {:>12}   {:.4f} s\n", num_linearizations, linearize_seconds);
  fmt::format_to(out, "linear solves                  {:.4f} s\n", linear_solve_seconds);
  fmt::format_to(out, "cost evaluations  {:>12}   {:.4f} s, over subsets {}\n", num_cost_evaluations, cost_seconds,
                 num_subset_evaluations);
  fmt::format_to(out, "total                          {:.4f} s\n\n", total_seconds);
  if (!phases.empty()) fmt::format_to(out, "{}\n", ProfileTable(phases));
  fmt::format_to(out, "{:>5} {:>16} {:>10} {:>9} {:>9} {:>6} {:>9} {:>9} {:>5} {:>9} {:>3} {:>9}\n", "iter", "cost",
                 "change", "rho", "lambda", "gamma", "|grad|", "|step|", "pcg", "pcg |r|", "ok", "seconds");
  for (const LmIteration& row : iterations) {
    fmt::format_to(
        out, "{:>5} {:>16.9e} {:>10.2e} {:>9.2e} {:>9.2e} {:>6.3f} {:>9.2e} {:>9.2e} {:>5} {:>9.2e} {:>3} {:>9.4f}\n",
        row.iteration, row.cost, row.cost_change, row.rho, row.lambda, row.gamma, row.gradient_max_norm, row.step_norm,
        row.pcg_iterations, row.pcg_residual, row.accepted ? "yes" : "no", row.seconds);
  }
  return text;
}

}  // namespace vesta
