// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/lm/engine_options.h"

namespace vesta::gs {

PhotometricWeights LossOf(const LmStageOptions& lm) {
  return {.l1 = lm.l1_weight,
          .ssim = lm.ssim_weight,
          .l1_floor = lm.l1_floor,
          .pixel = lm.loss_linearization,
          .huber_threshold = lm.huber_threshold,
          .structure = lm.ssim};
}

SplatProblemOptions SplatProblemOptionsOf(const LmStageOptions& lm, const splat::ModelLayout& layout) {
  SplatProblemOptions problem;
  static_cast<SplatMetricOptions&>(problem) = lm;
  static_cast<splat::ModelLayout&>(problem) = layout;
  problem.weights = LossOf(lm);
  problem.jacobian = lm.jacobian;
  return problem;
}

vesta::LmOptions LmEngineOptions(const LmStageOptions& lm) {
  vesta::LmOptions engine;
  engine.max_iterations = lm.iterations;
  engine.function_tolerance = lm.min_gain;
  engine.gradient_tolerance = 0;
  engine.parameter_tolerance = 0;
  engine.SetStepRule(lm.step_control);
  engine.step_control.initial_lambda = lm.initial_lambda;
  engine.step_control.min_lambda = lm.min_lambda;
  engine.step_control.max_lambda = lm.max_lambda;
  engine.column_scaling = ColumnScaling::kNone;
  NormalSystemOptions& system = engine.normal_system;
  system.metric.group_median_floor = lm.min_diagonal > 0 ? 0 : 1e-6;
  if (lm.min_diagonal > 0) system.metric.min_diagonal = lm.min_diagonal;
  if (lm.max_diagonal > 0) system.metric.max_diagonal = lm.max_diagonal;
  // Automatic: one of the problem's own where it gives one, else its blocks.
  system.preconditioner =
      lm.preconditioner == LmPreconditioner::kJacobi ? PreconditionerKind::kJacobi : PreconditionerKind::kAuto;
  if (lm.preconditioner_damping == PreconditionerDamping::kOne) system.preconditioner_lambda = 1;
  system.pcg.max_iterations = lm.pcg_iterations;
  system.pcg.start = lm.pcg_start;
  if (lm.pcg_tolerance > 0) system.pcg.relative_tolerance = lm.pcg_tolerance, system.pcg.model_tolerance = 0;
  engine.batch_mode = lm.merge_batches ? BatchMode::kMerge : BatchMode::kExact;
  engine.line_search.enabled = lm.line_search;
  engine.line_search.unit_fraction = lm.line_search_views;
  return engine;
}

}  // namespace vesta::gs
