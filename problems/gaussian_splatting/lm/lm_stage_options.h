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

// How products with J evaluate their raster part.
enum class JacobianKind {
  kCachedViews,  // recomputed from the cached splats of each view
  kCache32,      // entries of J stored as floats (doubles in double precision), see cache/jacobian_cache.h
  kCache16,      // entries of J stored in 16 bits
  // Like kCachedViews, but each product projects, sorts, renders and linearises the views again. The numbers are the
  // same; memory holds one view instead of all. On a device this is the same as kCachedViews.
  kOnTheFly,
};
inline constexpr schema::Choice<JacobianKind> kJacobianKinds[] = {{JacobianKind::kCachedViews, "cached_views"},
                                                                  {JacobianKind::kCache32, "cache32"},
                                                                  {JacobianKind::kCache16, "cache16"},
                                                                  {JacobianKind::kOnTheFly, "on_the_fly"}};
// True if entries of J are stored.
inline bool IsCached(JacobianKind kind) { return kind == JacobianKind::kCache32 || kind == JacobianKind::kCache16; }

// The damping metric D, by which lambda is multiplied.
enum class LmDamping {
  kLearningRates,  // from Adam's learning rates (lm/splat_blocks.h)
  kDiagonal,       // diag(JtJ)
};

enum class LmPreconditioner {
  kBlock,  // one block per Gaussian for its geometry, the diagonal for spherical harmonics
  kJacobi,
};

// Damping inside the preconditioner: the lambda of the system, or 1 (3DGS-LM).
enum class PreconditionerDamping { kLambda, kOne };

// Options that change the right-hand side and the damping.
struct SplatMetricOptions {
  LmDamping damping = LmDamping::kLearningRates;
  // How strongly each entry of the right-hand side is shrunk where the views of the batch disagree
  // (lm/gradient_shrinkage.h). 0: no shrinkage.
  double gradient_shrinkage = 0.3;
};

// Options of Levenberg-Marquardt on all training views (solver/), which starts where Adam stopped.
struct LmStageOptions : SplatMetricOptions {
  int iterations = 0;
  // The stage ends when an iteration lowers the cost by less than this fraction. On some scenes Adam leaves almost
  // nothing to gain (docs/decisions/lm-is-optional.md).
  double function_tolerance = 0.006;
  int pcg_iterations = 4;
  int batches = 1;
  int batch_size = 0;  // views per batch; 0: all views are divided among the batches
  BatchChoice batch_choice = BatchChoice::kStrided;
  // Several batches are solved together in one PCG, or one by one and then merged (3DGS-LM, eq. 7).
  bool merge_batches = false;
  LmPreconditioner preconditioner = LmPreconditioner::kBlock;
  PreconditionerDamping preconditioner_damping = PreconditionerDamping::kLambda;
  PcgStart pcg_start = PcgStart::kZero;
  // PCG stops when |residual| <= pcg_tolerance |b|; 0: when the quadratic model hardly decreases any more.
  double pcg_tolerance = 0;
  StepRule damping_update = StepRule::kCeres;
  // Caching the views shortens an iteration by a quarter but takes several times the memory of everything else
  // (docs/decisions/lm-jacobian-on-the-fly.md).
  JacobianKind jacobian = JacobianKind::kOnTheFly;
  bool line_search = false;
  double line_search_views = 0.3;
  double initial_lambda = 0.02;
  double min_lambda = 1e-5;
  double max_lambda = 1e4;
  // Range of diag(JtJ) in LmDamping::kDiagonal. 0: the minimum is 1e-6 of the median over the same parameter; no
  // maximum.
  double min_diagonal = 0, max_diagonal = 0;
  // The cost and its quadratic model: kernels/image/loss_options.h.
  PixelLinearization loss_linearization = PhotometricWeights{}.pixel;
  SsimLinearization ssim = PhotometricWeights{}.structure;
  double l1_weight = PhotometricWeights{}.l1, ssim_weight = PhotometricWeights{}.ssim;
  double l1_floor = PhotometricWeights{}.l1_floor;
  double huber_threshold = PhotometricWeights{}.huber_threshold;
};

const schema::Table<LmStageOptions>& LmStageFields();
// Throws Error with a one-line message if options contradict each other although each is in its range.
void CheckTogether(const LmStageOptions& lm);

// Conversions of the options for the loss, the problem (splat_problem.h) and the solver.
PhotometricWeights LossOf(const LmStageOptions& lm);
// For a model with this layout; the caller still sets batches, background, lr and units.
SplatProblemOptions SplatProblemOptionsOf(const LmStageOptions& lm, const splat::ModelLayout& layout);
vesta::LmOptions LmEngineOptions(const LmStageOptions& lm);

}  // namespace vesta::gs
