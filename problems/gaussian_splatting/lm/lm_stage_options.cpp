// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/lm/lm_stage_options.h"

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "solver/internal/normal_equations/damped_normal_equations.h"
#include "solver/lm_options.h"

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
  engine.function_tolerance = lm.function_tolerance;
  engine.gradient_tolerance = 0;
  engine.parameter_tolerance = 0;
  engine.SetStepRule(lm.damping_update);
  engine.step_control.initial_lambda = lm.initial_lambda;
  engine.step_control.min_lambda = lm.min_lambda;
  engine.step_control.max_lambda = lm.max_lambda;
  engine.column_scaling = ColumnScaling::kNone;
  NormalSystemOptions& system = engine.normal_system;
  system.metric.group_median_floor = lm.min_diagonal > 0 ? 0 : 1e-6;
  if (lm.min_diagonal > 0) system.metric.min_diagonal = lm.min_diagonal;
  if (lm.max_diagonal > 0) system.metric.max_diagonal = lm.max_diagonal;
  // kAuto: the problem's own preconditioner if it provides one, otherwise its diagonal blocks.
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

namespace {

using schema::Choice;

constexpr Choice<BatchChoice> kBatchChoices[] = {{BatchChoice::kStrided, "strided"}, {BatchChoice::kRandom, "random"}};
constexpr Choice<LmDamping> kDampings[] = {{LmDamping::kLearningRates, "lr"}, {LmDamping::kDiagonal, "diag"}};
constexpr Choice<LmPreconditioner> kPreconditioners[] = {{LmPreconditioner::kBlock, "block"},
                                                         {LmPreconditioner::kJacobi, "jacobi"}};
constexpr Choice<PreconditionerDamping> kPreconditionerDampings[] = {{PreconditionerDamping::kLambda, "lambda"},
                                                                     {PreconditionerDamping::kOne, "one"}};
constexpr Choice<PcgStart> kPcgStarts[] = {{PcgStart::kZero, "zero"}, {PcgStart::kPreconditioned, "preconditioned"}};
constexpr Choice<StepRule> kStepRules[] = {
    {StepRule::kCeres, "ceres"}, {StepRule::k3dgsLmV2, "paper"}, {StepRule::k3dgsLmCode, "paper_code"}};
constexpr Choice<PixelLinearization> kPixelLinearizations[] = {{PixelLinearization::kIrls, "irls"},
                                                               {PixelLinearization::kSqrt, "sqrt"},
                                                               {PixelLinearization::kHuber, "huber"},
                                                               {PixelLinearization::kL2, "l2"}};
constexpr Choice<SsimLinearization> kSsimLinearizations[] = {{SsimLinearization::kQuadratic, "quadratic"},
                                                             {SsimLinearization::kRootCenter, "root_center"}};
static_assert(schema::EachOnce(kJacobianKinds) && schema::EachOnce(kBatchChoices) && schema::EachOnce(kDampings) &&
              schema::EachOnce(kPreconditioners) && schema::EachOnce(kPreconditionerDampings) &&
              schema::EachOnce(kPcgStarts) && schema::EachOnce(kStepRules) && schema::EachOnce(kPixelLinearizations) &&
              schema::EachOnce(kSsimLinearizations));

}  // namespace

const schema::Table<LmStageOptions>& LmStageFields() {
  using O = LmStageOptions;
  constexpr schema::Range kCount{1, 1e6}, kPositive{1e-30, 1e30}, kWeight{0, 1e6}, kFromZero{0, 1e30};
  static const schema::Table<O> fields = {
      {"iterations",
       &O::iterations,
       {0, 1e6},
       "at most N Levenberg-Marquardt (LM) iterations after Adam, on all training views; 0: no LM stage",
       "lm_iterations"},
      {"function_tolerance",
       &O::function_tolerance,
       {0, 1},
       "end the LM stage when an iteration lowers the training loss by less than this fraction; 0: never"},
      {"pcg_iterations", &O::pcg_iterations, kCount, "at most N conjugate-gradient (PCG) iterations per LM iteration"},
      {"pcg_tolerance",
       &O::pcg_tolerance,
       {0, 1},
       "end PCG at this residual relative to the right-hand side; 0: when the quadratic model hardly falls further"},
      {"pcg_start", &O::pcg_start, kPcgStarts, "start vector of PCG: zero, or the preconditioned gradient"},
      {"preconditioner", &O::preconditioner, kPreconditioners,
       "preconditioner of PCG: 11 x 11 blocks of JtJ for the geometry of each Gaussian, or diag(JtJ)"},
      {"preconditioner_damping", &O::preconditioner_damping, kPreconditionerDampings,
       "damping inside the preconditioner: lambda as in the system, or 1"},
      {"damping", &O::damping, kDampings, "metric of the LM damping: from Adam's learning rates, or diag(JtJ)"},
      {"damping_update", &O::damping_update, kStepRules,
       "rule that updates lambda: of Ceres, of the 3DGS-LM paper, or of its code"},
      {"initial_lambda", &O::initial_lambda, kPositive, "lambda, the LM damping, in the first iteration"},
      {"min_lambda", &O::min_lambda, kPositive, "smallest lambda of the LM damping"},
      {"max_lambda", &O::max_lambda, kPositive, "largest lambda of the LM damping"},
      {"min_diagonal", &O::min_diagonal, kFromZero,
       "smallest entry of diag(JtJ) in the damping; 0: 1e-6 of the median of the same parameter"},
      {"max_diagonal", &O::max_diagonal, kFromZero, "largest entry of diag(JtJ) in the damping; 0: no limit"},
      {"gradient_shrinkage", &O::gradient_shrinkage, kWeight,
       "shrink gradient entries on which the views disagree; larger: shrink more; 0: off"},
      {"line_search", &O::line_search, "search along each LM step for the best step length"},
      {"line_search_views",
       &O::line_search_views,
       {1e-6, 1},
       "fraction of the training views that the line search evaluates"},
      {"batches", &O::batches, kCount, "number of batches into which the training views are divided"},
      {"batch_size",
       &O::batch_size,
       {0, 1e6},
       "views per batch of the LM stage; 0: divide all training views among lm.batches"},
      {"batch_choice", &O::batch_choice, kBatchChoices,
       "how views are assigned to batches: every n-th view, or at random"},
      {"merge_batches", &O::merge_batches,
       "solve each batch on its own and merge the steps (3DGS-LM, eq. 7), instead of one PCG for all"},
      {"jacobian", &O::jacobian, kJacobianKinds,
       "products with J: from cached views, from cached entries of J (32 or 16 bits), or with the views rendered again "
       "each time (least memory)"},
      {"loss_linearization", &O::loss_linearization, kPixelLinearizations,
       "quadratic model of |error|: reweighted least squares, square of its root, Huber, or plain squares"},
      {"huber_threshold",
       &O::huber_threshold,
       {1e-6, 1e6},
       "pixel error below which the Huber loss is quadratic (colours are 0 to 1)"},
      {"l1_floor", &O::l1_floor, {1e-6, 1}, "pixel error below which irls uses a plain square (colours are 0 to 1)"},
      {"l1_weight", &O::l1_weight, kWeight, "weight of |error| in the loss of the LM stage"},
      {"ssim", &O::ssim, kSsimLinearizations,
       "quadratic model of SSIM: reweighted, or Gauss-Newton on the root of 1 - SSIM at each window's centre"},
      {"ssim_weight", &O::ssim_weight, kWeight, "weight of 1 - SSIM in the loss of the LM stage"},
  };
  return fields;
}

void ValidateCombination(const LmStageOptions& lm) {
  if (lm.min_lambda > lm.initial_lambda || lm.initial_lambda > lm.max_lambda) {
    Fail(kBadArgument, "lm.initial_lambda={}: it must be between lm.min_lambda={} and lm.max_lambda={}",
         lm.initial_lambda, lm.min_lambda, lm.max_lambda);
  }
  // If lm.min_diagonal is 0, the solver's default applies.
  const double least = lm.min_diagonal > 0 ? lm.min_diagonal : DampingMetricOptions{}.min_diagonal;
  if (lm.max_diagonal > 0 && lm.max_diagonal < least) {
    Fail(kBadArgument, "lm.max_diagonal={}: it must be 0 or at least {}, the minimum that lm.min_diagonal={} sets",
         lm.max_diagonal, least, lm.min_diagonal);
  }
}

}  // namespace vesta::gs
