#include "solver/lm_options.h"

#include <limits>

#include "kernels/core/check.h"

namespace vesta {

const char* ToString(BatchMode mode) { return mode == BatchMode::kExact ? "exact sum of batches" : "batch merge"; }

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

void LsmrOptions::Validate() const {
  if (max_iterations < 0) Fail("lsmr.max_iterations is {}; choose 0 or more", max_iterations);
  if (!(relative_tolerance > 0 && relative_tolerance < 1)) {
    Fail("lsmr.relative_tolerance is {}; choose a value within (0, 1)", relative_tolerance);
  }
}

void PcgOptions::Validate() const {
  if (max_iterations < 0) Fail("pcg.max_iterations is {}; choose 0 or more", max_iterations);
  if (min_iterations < 0) Fail("pcg.min_iterations is {}; choose 0 or more", min_iterations);
  if (residual_reset_period < 0) Fail("pcg.residual_reset_period is {}; choose 0 or more", residual_reset_period);
  for (const double tolerance : {relative_tolerance, absolute_tolerance, model_tolerance}) {
    if (!(tolerance >= 0)) Fail("a tolerance of pcg is {}; choose 0 or more", tolerance);
  }
}

void DampingMetricOptions::Validate() const {
  if (!(min_diagonal > 0 && min_diagonal <= max_diagonal)) {
    Fail("metric: D is clamped to [{}, {}]; need 0 < min_diagonal <= max_diagonal", min_diagonal, max_diagonal);
  }
  if (!(group_median_floor >= 0)) Fail("metric.group_median_floor is {}; choose 0 or more", group_median_floor);
}

void LineSearchOptions::Validate() const {
  if (!(unit_fraction > 0 && unit_fraction <= 1)) {
    Fail("line_search.unit_fraction is {}; choose it within (0, 1]", unit_fraction);
  }
  if (!(shrink > 0 && shrink < 1)) Fail("line_search.shrink is {}; choose it within (0, 1)", shrink);
  if (max_evaluations < 2) Fail("line_search.max_evaluations is {}; choose 2 or more", max_evaluations);
}

void LmOptions::Validate() const {
  if (max_iterations < 0) Fail("max_iterations is {}; choose 0 or more", max_iterations);
  if (max_consecutive_rejects < 1) Fail("max_consecutive_rejects is {}; choose 1 or more", max_consecutive_rejects);
  if (!(max_seconds > 0)) Fail("max_seconds is {}; choose more than 0", max_seconds);
  for (const double tolerance : {function_tolerance, gradient_tolerance, parameter_tolerance}) {
    if (!(tolerance >= 0)) Fail("a tolerance of the solve is {}; choose 0 or more", tolerance);
  }
  step_control.Validate();
  const double preconditioner_lambda = normal_system.preconditioner_lambda.value_or(0);
  if (!(preconditioner_lambda >= 0 && preconditioner_lambda <= std::numeric_limits<double>::max())) {
    Fail("normal_system.preconditioner_lambda is {}; choose 0 or more", preconditioner_lambda);
  }
  normal_system.pcg.Validate();
  normal_system.lsmr.Validate();
  normal_system.metric.Validate();
  line_search.Validate();
}

}  // namespace vesta
