// SPDX-License-Identifier: Apache-2.0
// Options of the LM stage: Levenberg-Marquardt (LM) on all training views, after Adam. Each step solves (H + lambda D)
// step = right-hand side by PCG, where H approximates J^T W J summed over the views (docs/mathematics.md).
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

// Data stored for products with the Jacobian J of the pixels.
enum class JacobianKind {
  kCachedViews,  // projected and sorted splats, image and loss fields per view; products recompute entries of J
  kCache32,      // also entries of J as floats (doubles in double precision), see cache/jacobian_cache.h
  kCache16,      // also entries of J in 16 bits
  // Nothing: each product builds the views again, with results bit-identical to kCachedViews. On a GPU with enough
  // memory the training uses kCachedViews instead (splatting/memory/memory_plan.h).
  kOnTheFly,
};
inline constexpr schema::Choice<JacobianKind> kJacobianKinds[] = {{JacobianKind::kCachedViews, "cached_views"},
                                                                  {JacobianKind::kCache32, "cache32"},
                                                                  {JacobianKind::kCache16, "cache16"},
                                                                  {JacobianKind::kOnTheFly, "on_the_fly"}};
// True if entries of J are stored.
inline bool IsCached(JacobianKind kind) { return kind == JacobianKind::kCache32 || kind == JacobianKind::kCache16; }

// The damping metric D, a diagonal matrix.
enum class LmDamping {
  kLearningRates,  // from Adam's learning rates (lm/splat_blocks.h)
  kDiagonal,       // diag(JtJ)
};

enum class LmPreconditioner {
  kBlock,   // of H: an 11 x 11 block per Gaussian for its geometry, and the diagonal for spherical harmonics
  kJacobi,  // the diagonal of H
};

// Factor of D in the preconditioner: lambda as in the system, or 1 (3DGS-LM).
enum class PreconditionerDamping { kLambda, kOne };

// Options that change the right-hand side and the damping.
struct SplatMetricOptions {
  LmDamping damping = LmDamping::kLearningRates;
  // Shrinks entries of the right-hand side on which the views of the batch disagree (lm/gradient_shrinkage.h). 0: no
  // shrinkage.
  double gradient_shrinkage = 0.3;
};

// The option lm.NAME is the member NAME. Help: `vesta help train --all`.
struct LmStageOptions : SplatMetricOptions {
  int iterations = 0;  // at most; 0: no LM stage
  // The stage ends when an iteration lowers the cost by less than this fraction (docs/decisions/lm-is-optional.md).
  double function_tolerance = 0.006;
  int pcg_iterations = 4;
  int batches = 1;     // batches of views per iteration
  int batch_size = 0;  // views per batch; 0: all views are divided among the batches
  BatchChoice batch_choice = BatchChoice::kStrided;
  // True: each batch is solved alone, and the steps are averaged (3DGS-LM, eq. 7). False: PCG solves the sum of the
  // batches.
  bool merge_batches = false;
  LmPreconditioner preconditioner = LmPreconditioner::kBlock;
  PreconditionerDamping preconditioner_damping = PreconditionerDamping::kLambda;
  PcgStart pcg_start = PcgStart::kZero;
  // PCG stops when |residual| <= pcg_tolerance |right-hand side|; 0: when an iteration hardly lowers the quadratic
  // model.
  double pcg_tolerance = 0;
  StepRule damping_update = StepRule::kCeres;
  // kCachedViews makes an iteration a quarter shorter but needs several times the memory of everything else
  // (docs/decisions/lm-jacobian-on-the-fly.md).
  JacobianKind jacobian = JacobianKind::kOnTheFly;
  bool line_search = false;
  double line_search_views = 0.3;  // fraction of the views in the line search
  double initial_lambda = 0.02;
  double min_lambda = 1e-5;
  double max_lambda = 1e4;
  // Limits of D for LmDamping::kDiagonal. min_diagonal = 0 means 1e-6 of the median entry of the same kind of
  // parameter; max_diagonal = 0 means no limit.
  double min_diagonal = 0, max_diagonal = 0;
  // The cost and its quadratic model: kernels/image/loss_options.h.
  PixelLinearization loss_linearization = PhotometricWeights{}.pixel;
  SsimLinearization ssim = PhotometricWeights{}.structure;
  double l1_weight = PhotometricWeights{}.l1, ssim_weight = PhotometricWeights{}.ssim;
  double l1_floor = PhotometricWeights{}.l1_floor;
  double huber_threshold = PhotometricWeights{}.huber_threshold;
};

const schema::Table<LmStageOptions>& LmStageFields();
// Throws Error if options contradict each other.
void ValidateCombination(const LmStageOptions& lm);

// Options for the loss, the problem (splat_problem.h) and the solver.
PhotometricWeights LossOf(const LmStageOptions& lm);
// Batches, background, lr and units keep their defaults; the caller sets them.
SplatProblemOptions SplatProblemOptionsOf(const LmStageOptions& lm, const splat::ModelLayout& layout);
vesta::LmOptions LmEngineOptions(const LmStageOptions& lm);

}  // namespace vesta::gs
