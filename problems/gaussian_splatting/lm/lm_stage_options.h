// SPDX-License-Identifier: Apache-2.0
// Options of the LM stage.
#pragma once

#include "kernels/core/schema.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/image/loss_options.h"
#include "problems/gaussian_splatting/lm/view_batches.h"
#include "solver/internal/linear/pcg.h"
#include "solver/internal/trust_region/step_control.h"

namespace vesta {
struct LmOptions;
}

namespace vesta::gs {

struct SplatProblemOptions;

// What products with J take their raster part from.
enum class JacobianKind {
  kCachedViews,  // the splats, each time
  kCache32,      // entries kept as floats (doubles in double) or as 16 bits:
                 // kernels/gaussian_splatting/cache/jacobian_cache.h
  kCache16,
  // As kCachedViews, and views are projected, sorted, rendered and linearised anew for each product: the same numbers,
  // and the memory of one view instead of that of all. On a device as kCachedViews.
  kOnTheFly,
};
inline constexpr schema::Choice<JacobianKind> kJacobianKinds[] = {{JacobianKind::kCachedViews, "cached_views"},
                                                                  {JacobianKind::kCache32, "cache32"},
                                                                  {JacobianKind::kCache16, "cache16"},
                                                                  {JacobianKind::kOnTheFly, "on_the_fly"}};
// Whether entries of J are kept.
inline bool IsCached(JacobianKind kind) { return kind == JacobianKind::kCache32 || kind == JacobianKind::kCache16; }

// D, the metric in which lambda damps.
enum class LmDamping {
  kLearningRates,  // that of Adam's learning rates (lm/splat_blocks.h)
  kDiagonal,       // diag(JtJ)
};

enum class LmPreconditioner {
  kBlock,  // the geometry of each Gaussian a block, its harmonics by their diagonal
  kJacobi,
};

// What damps the preconditioner: the damping of the system, or D itself (3DGS-LM).
enum class PreconditionerDamping { kLambda, kOne };

// What the problem makes of the gradient and of the damping.
struct SplatMetricOptions {
  LmDamping damping = LmDamping::kLearningRates;
  // How strongly each entry of the descent is shrunk by the disagreement of the batch's views about it
  // (lm/gradient_shrinkage.h). 0: not at all.
  double gradient_shrinkage = 0.3;
};

// Levenberg-Marquardt on all training views (solver/), started from where Adam stopped.
struct LmStageOptions : SplatMetricOptions {
  int iterations = 0;
  // The stage ends sooner where an iteration lowers the cost by a smaller part than this: on some scenes Adam leaves
  // next to nothing to gain (docs/decisions/lm-is-optional.md).
  double function_tolerance = 0.006;
  int pcg_iterations = 4;
  int batches = 1;
  int batch_size = 0;  // views in each; 0: all are divided among the batches
  BatchChoice batch_choice = BatchChoice::kStrided;
  // Several batches: solved together in one PCG, or one by one and merged (3DGS-LM, eq. 7).
  bool merge_batches = false;
  LmPreconditioner preconditioner = LmPreconditioner::kBlock;
  PreconditionerDamping preconditioner_damping = PreconditionerDamping::kLambda;
  PcgStart pcg_start = PcgStart::kZero;
  // Stop PCG where |residual| <= pcg_tolerance |b|; 0: where the quadratic model hardly falls any more.
  double pcg_tolerance = 0;
  StepRule damping_update = StepRule::kCeres;
  // Views that are held shorten an iteration by a quarter and take several times the memory of all else
  // (docs/decisions/lm-jacobian-on-the-fly.md).
  JacobianKind jacobian = JacobianKind::kOnTheFly;
  bool line_search = false;
  double line_search_views = 0.3;
  double initial_lambda = 0.02;
  double min_lambda = 1e-5;
  double max_lambda = 1e4;
  // Range of diag(JtJ) in LmDamping::kDiagonal; 0: at least 1e-6 of the median of the same parameter, no upper end.
  double min_diagonal = 0, max_diagonal = 0;
  // The cost and its quadratic: kernels/image/loss_options.h.
  PixelLinearization loss_linearization = PhotometricWeights{}.pixel;
  SsimLinearization ssim = PhotometricWeights{}.structure;
  double l1_weight = PhotometricWeights{}.l1, ssim_weight = PhotometricWeights{}.ssim;
  double l1_floor = PhotometricWeights{}.l1_floor;
  double huber_threshold = PhotometricWeights{}.huber_threshold;
};

const schema::Table<LmStageOptions>& LmStageFields();
// Throws Error, one line, for options that are each in range and do not go together.
void CheckTogether(const LmStageOptions& lm);

// The options in the terms of the loss, of the problem (splat_problem.h) and of the engine.
//
// Of the cost.
PhotometricWeights LossOf(const LmStageOptions& lm);
// Of a model so laid out; batches, background, rates and units are the caller's to set.
SplatProblemOptions SplatProblemOptionsOf(const LmStageOptions& lm, const splat::ModelLayout& layout);
vesta::LmOptions LmEngineOptions(const LmStageOptions& lm);

}  // namespace vesta::gs
