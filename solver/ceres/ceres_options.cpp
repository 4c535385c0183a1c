// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "solver/ceres/ceres_solve.h"

namespace vesta::ceres_bridge {

LmOptions FromCeres(const ceres::Solver::Options& from) {
  LmOptions options;
  options.max_iterations = from.max_num_iterations;
  options.max_seconds = from.max_solver_time_in_seconds;
  options.function_tolerance = from.function_tolerance;
  options.gradient_tolerance = from.gradient_tolerance;
  options.parameter_tolerance = from.parameter_tolerance;
  options.step_control.initial_lambda = 1 / from.initial_trust_region_radius;
  options.step_control.min_lambda = 1 / from.max_trust_region_radius;
  options.step_control.max_lambda = 1 / from.min_trust_region_radius;
  options.step_control.min_relative_decrease = from.min_relative_decrease;
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
    case ceres::SPARSE_NORMAL_CHOLESKY:
      system.linear_solver = LinearSolverKind::kPcg;
      system.preconditioner = PreconditionerKind::kSparseCholesky;
      // To rounding, as a direct solver; the second test is for systems whose rounding is above the first.
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
  changed(&Options::use_nonmonotonic_steps, "use_nonmonotonic_steps", "no step may raise the cost");
  changed(&Options::use_inner_iterations, "use_inner_iterations", "there are none");
  changed(&Options::check_gradients, "check_gradients", "call solver/derivative_check.h in a test");
  changed(&Options::num_threads, "num_threads", "all cores are used; call vesta::SetNumThreads");
  changed(&Options::max_num_consecutive_invalid_steps, "max_num_consecutive_invalid_steps",
          "set max_consecutive_rejects of what FromCeres gives");
  changed(&Options::minimizer_progress_to_stdout, "minimizer_progress_to_stdout", "the library prints nothing");
  note(options.linear_solver_ordering != nullptr, "linear_solver_ordering", "the group to eliminate is found");
  changed(&Options::use_explicit_schur_complement, "use_explicit_schur_complement", "it is always implicit");
  const bool iterative =
      options.linear_solver_type == ceres::CGNR || options.linear_solver_type == ceres::ITERATIVE_SCHUR;
  note(iterative && options.preconditioner_type != ceres::IDENTITY && options.preconditioner_type != ceres::JACOBI &&
           options.preconditioner_type != ceres::SCHUR_JACOBI,
       "preconditioner_type", "block Jacobi, or Schur-Jacobi, is used");
  changed(&Options::dynamic_sparsity, "dynamic_sparsity", "the sparsity is that of the blocks");
  changed(&Options::use_mixed_precision_solves, "use_mixed_precision_solves", "all is in double");
  changed(&Options::max_num_refinement_iterations, "max_num_refinement_iterations", "PCG refines by its own tests");
  note(!options.trust_region_minimizer_iterations_to_dump.empty(), "trust_region_minimizer_iterations_to_dump",
       "nothing is written");
  return ignored;
}

}  // namespace vesta::ceres_bridge
