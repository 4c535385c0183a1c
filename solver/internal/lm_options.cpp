// SPDX-License-Identifier: Apache-2.0
// Validation of LmOptions and its nested options, and names of their enumerators.
#include "solver/lm_options.h"

#include <limits>

#include "kernels/core/check.h"

namespace vesta {

const char* ToString(LinearSolverKind kind) {
  switch (kind) {
    case LinearSolverKind::kAuto:
      return "automatic";
    case LinearSolverKind::kPcg:
      return "PCG";
    case LinearSolverKind::kReducedPcg:
      return "PCG on the Schur complement";
    case LinearSolverKind::kLsmr:
      return "LSMR";
    case LinearSolverKind::kDenseQr:
      return "dense QR";
  }
  return "unknown";
}

const char* ToString(PreconditionerKind kind) {
  switch (kind) {
    case PreconditionerKind::kAuto:
      return "automatic";
    case PreconditionerKind::kIdentity:
      return "no preconditioner";
    case PreconditionerKind::kJacobi:
      return "Jacobi";
    case PreconditionerKind::kBlockJacobi:
      return "block Jacobi";
    case PreconditionerKind::kProblem:
      return "the problem's preconditioner";
    case PreconditionerKind::kSparseCholesky:
      return "sparse Cholesky";
  }
  return "unknown";
}

void DampingMetricOptions::Validate() const {
  if (!(min_diagonal > 0 && min_diagonal <= max_diagonal)) {
    Fail(kBadArgument, "metric: D is clamped to [{}, {}]; need 0 < min_diagonal <= max_diagonal", min_diagonal,
         max_diagonal);
  }
  if (!(group_median_floor >= 0))
    Fail(kBadArgument, "metric.group_median_floor is {}; choose 0 or more", group_median_floor);
}

void LsmrOptions::Validate() const {
  if (max_iterations < 0) Fail(kBadArgument, "lsmr.max_iterations is {}; choose 0 or more", max_iterations);
  if (!(relative_tolerance > 0 && relative_tolerance < 1)) {
    Fail(kBadArgument, "lsmr.relative_tolerance is {}; choose a value within (0, 1)", relative_tolerance);
  }
}

const char* ToString(PcgStatus status) {
  switch (status) {
    case PcgStatus::kConverged:
      return "converged";
    case PcgStatus::kModelConverged:
      return "model converged";
    case PcgStatus::kMaxIterations:
      return "iteration limit";
    case PcgStatus::kIndefinite:
      return "indefinite";
    case PcgStatus::kNonFinite:
      return "not finite";
  }
  return "unknown";
}

void PcgOptions::Validate() const {
  if (max_iterations < 0) Fail(kBadArgument, "pcg.max_iterations is {}; choose 0 or more", max_iterations);
  if (min_iterations < 0) Fail(kBadArgument, "pcg.min_iterations is {}; choose 0 or more", min_iterations);
  if (residual_reset_period < 0)
    Fail(kBadArgument, "pcg.residual_reset_period is {}; choose 0 or more", residual_reset_period);
  for (const double tolerance : {relative_tolerance, absolute_tolerance, model_tolerance}) {
    if (!(tolerance >= 0)) Fail(kBadArgument, "a tolerance of pcg is {}; choose 0 or more", tolerance);
  }
}

const char* ToString(BatchMode mode) { return mode == BatchMode::kExact ? "exact sum of batches" : "batch merge"; }

void LmOptions::Validate() const {
  if (max_iterations < 0) Fail(kBadArgument, "max_iterations is {}; choose 0 or more", max_iterations);
  if (max_consecutive_rejects < 1)
    Fail(kBadArgument, "max_consecutive_rejects is {}; choose 1 or more", max_consecutive_rejects);
  if (!(max_seconds >= 0)) Fail(kBadArgument, "max_seconds is {}; choose 0 or more", max_seconds);
  const auto check = [](const char* name, double tolerance) {
    if (!(tolerance >= 0)) Fail(kBadArgument, "{} is {}; choose 0 or more", name, tolerance);
  };
  check("function_tolerance", function_tolerance);
  check("gradient_tolerance", gradient_tolerance);
  check("parameter_tolerance", parameter_tolerance);
  step_control.Validate();
  if (step_control.rule != step_rule) {
    Fail(kBadArgument,
         "step_rule is {}, while step_control has the values of {}; choose a rule by SetStepRule, then change values",
         ToString(step_rule), ToString(step_control.rule));
  }
  const double preconditioner_lambda = normal_system.preconditioner_lambda.value_or(0);
  if (!(preconditioner_lambda >= 0 && preconditioner_lambda <= std::numeric_limits<double>::max())) {
    Fail(kBadArgument, "normal_system.preconditioner_lambda is {}; choose 0 or more", preconditioner_lambda);
  }
  normal_system.pcg.Validate();
  normal_system.lsmr.Validate();
  normal_system.metric.Validate();
  line_search.Validate();
}

}  // namespace vesta
