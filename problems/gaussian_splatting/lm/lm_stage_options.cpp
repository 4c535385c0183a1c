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
static_assert(schema::AreDistinct(kJacobianKinds) && schema::AreDistinct(kBatchChoices) &&
              schema::AreDistinct(kDampings) && schema::AreDistinct(kPreconditioners) &&
              schema::AreDistinct(kPreconditionerDampings) && schema::AreDistinct(kPcgStarts) &&
              schema::AreDistinct(kStepRules) && schema::AreDistinct(kPixelLinearizations) &&
              schema::AreDistinct(kSsimLinearizations));

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
       "end PCG at this residual, relative to the right-hand side; 0: when an iteration lowers the quadratic model by "
       "little of its whole decrease"},
      {"pcg_start", &O::pcg_start, kPcgStarts,
       "first iterate of PCG: zero, or the preconditioned gradient, which costs one more product"},
      {"preconditioner", &O::preconditioner, kPreconditioners,
       "preconditioner of PCG, from J, the derivatives of the pixels by the parameters: the 11 x 11 block of JtJ for "
       "the geometry of each Gaussian (fewer iterations, each slower), or diag(JtJ) only"},
      {"preconditioner_damping", &O::preconditioner_damping, kPreconditionerDampings,
       "factor of the damping matrix inside the preconditioner: lambda as in the system, or always 1"},
      {"damping", &O::damping, kDampings,
       "diagonal matrix that lambda multiplies in the damping: about proportional to 1 / (lr.*)^2 of each parameter, "
       "in the "
       "scale of diag(JtJ), or diag(JtJ) itself"},
      {"damping_update", &O::damping_update, kStepRules,
       "rule that changes lambda after each step: as Ceres, as the 3DGS-LM paper, or as its code"},
      {"initial_lambda", &O::initial_lambda, kPositive, "lambda, the LM damping, in the first iteration"},
      {"min_lambda", &O::min_lambda, kPositive, "smallest lambda of the LM damping"},
      {"max_lambda", &O::max_lambda, kPositive, "largest lambda of the LM damping"},
      {"min_diagonal", &O::min_diagonal, kFromZero,
       "smallest entry of diag(JtJ) with lm.damping=diag; 0: 1e-6 of the median entry of the same kind of parameter"},
      {"max_diagonal", &O::max_diagonal, kFromZero, "largest entry of diag(JtJ) with lm.damping=diag; 0: no limit"},
      {"gradient_shrinkage", &O::gradient_shrinkage, kWeight,
       "K of the factor max(0, 1 - K v / g^2) on each gradient entry g, with v its variance over the training views; "
       "0: off"},
      {"line_search", &O::line_search, "search along each LM step for the best step length"},
      {"line_search_views",
       &O::line_search_views,
       {1e-6, 1},
       "fraction of the training views that the line search evaluates"},
      {"batches", &O::batches, kCount,
       "number of batches of training views; their systems are summed, or solved one by one with lm.merge_batches"},
      {"batch_size",
       &O::batch_size,
       {0, 1e6},
       "views per batch, so that an iteration uses lm.batches times as many; 0: divide all training views"},
      {"batch_choice", &O::batch_choice, kBatchChoices,
       "how views are assigned to batches: every n-th view, or at random"},
      {"merge_batches", &O::merge_batches,
       "solve each batch alone and average the steps (3DGS-LM, equation 7); false: solve one system of all batches"},
      {"jacobian", &O::jacobian, kJacobianKinds,
       "for products with the Jacobian J, keep the projected Gaussians of all views, or the entries of J in 32 or 16 "
       "bits (most memory), or render the views again for each product (least memory)"},
      {"loss_linearization", &O::loss_linearization, kPixelLinearizations,
       "least-squares form of |error|: squares weighted by 1/|error|, or residuals sqrt(|error|); huber, l2: the LM "
       "loss "
       "itself has the Huber loss or plain squares instead of |error|"},
      {"huber_threshold",
       &O::huber_threshold,
       {1e-6, 1e6},
       "colour error (of 0 to 1) below which the Huber loss is quadratic"},
      {"l1_floor", &O::l1_floor, {1e-6, 1}, "colour error (of 0 to 1) below which irls uses a plain square"},
      {"l1_weight", &O::l1_weight, kWeight, "weight of |error| in the loss of the LM stage"},
      {"ssim", &O::ssim, kSsimLinearizations,
       "least-squares form of SSIM: a quadratic with its value and gradient, or residuals sqrt(1 - SSIM) derived only "
       "by "
       "the pixel at the centre of each window (3DGS-LM)"},
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
