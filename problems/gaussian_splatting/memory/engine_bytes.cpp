#include "problems/gaussian_splatting/memory/engine_bytes.h"

#include <algorithm>
#include <cmath>

#include "kernels/gaussian_splatting/layout.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/adam/adam.h"
#include "problems/gaussian_splatting/adam/block_adam_formula.h"
#include "problems/gaussian_splatting/lm/view_batches.h"

namespace vesta::gs {
namespace {

constexpr int Packed(int size) { return size * (size + 1) / 2; }

// What the preconditioner is made of, for one linearization or system. A linearization measures its Gram matrices for
// the diagonal and holds them until they have become blocks, which become factors in place. Jacobi never asks for
// blocks: the matrices stay, beside the diagonal, its inverse, and ones.
struct PreconditionerParts {
  double gram, blocks;
  bool keeps_gram;
};

PreconditionerParts PartsOf(const MemoryScene& scene, const LmOptions& lm) {
  const int coefficients = ShCoefficients(scene.sh_degree);
  const bool with_colors = lm.preconditioner == "block_sh";
  const double color_blocks = with_colors ? Packed(coefficients) : 0;
  const double gram = (Packed(splat::kGeometry) + 3 * coefficients + color_blocks) * PerGaussianBytes(scene);
  if (lm.preconditioner == "jacobi") return {gram, 3 * VectorBytes(scene), true};
  const double colors = with_colors ? color_blocks : 3 * coefficients;
  return {gram, (Packed(splat::kGeometry) + colors) * PerGaussianBytes(scene), false};
}

}  // namespace

double VectorBytes(const MemoryScene& scene) { return splat::NumAttributes(scene.sh_degree) * PerGaussianBytes(scene); }

double PerGaussianBytes(const MemoryScene& scene) { return sizeof(float) * static_cast<double>(scene.gaussians); }

double BasesBytes(const MemoryScene& scene, const AdamOptions& options) {
  return MetricOf(options) == AdamMetric::kBlock ? sizeof(float) * static_cast<double>(BlockArraySize(scene.gaussians))
                                                 : 0;
}

int LossImages(const LmOptions& lm) {
  if (lm.ssim_linearization != "root") return 2;
  return lm.ssim_jacobian == "center" ? 1 : 5;
}

double EngineBytes(const MemoryScene& scene, const LmOptions& lm, bool hold_batches, double views_bytes,
                   const PassingBytes& passing) {
  const auto views = static_cast<double>(scene.views.size());
  const auto batches =
      static_cast<double>(ViewBatches::CutCount(lm.batches, lm.batch_size, static_cast<Index>(scene.views.size())));
  // Views in each batch, up to one more in some than in others.
  const double size = std::ceil(lm.batch_size > 0 ? std::min<double>(lm.batch_size, views) : views / batches);
  const double held = hold_batches ? std::min(batches * size, views) : std::min(size, views);
  const bool several = batches > 1, merged = several && lm.merge_batches, summed = several && !merged;
  const double linearizations = hold_batches ? batches : 1, systems = hold_batches && merged ? batches : 1;
  const double vector = VectorBytes(scene);
  const PreconditionerParts parts = PartsOf(scene, lm);
  const double grams = linearizations * parts.gram, blocks = systems * parts.blocks;
  // x. Where batches are merged the sums of their gradients and diagonals, and what one of them would do.
  const double always = (1 + (merged ? 3 : 0)) * vector;
  // Gradient and diagonal of each system, its descent where that is another than the gradient's, and a batch's part of
  // them; the last linearization measures.
  const int own_descent = lm.view_agreement > 0 ? 1 : 0;
  const double linearizing = ((2 + own_descent) * systems + (summed ? 1 : 0)) * vector + grams + passing.gram;
  // D, and room for the blocks. So it is when x is evaluated.
  const double prepared = (3 + own_descent) * systems * vector + grams + blocks + passing.evaluation;
  // Gradient, descent and D, of merged batches the diagonal; the step; three vectors of PCG, of several batches the sum
  // of their products. Of merged batches the first is solved while the others have their Gram matrices still. Where the
  // model is measured along a step, one to hold H's product with it.
  const double kept = (2 + own_descent + (merged ? 1 : 0)) * systems * vector + vector + blocks;
  const double kept_grams = parts.keeps_gram ? grams : 0;
  const double measured = merged || lm.step_limit != "none" ? linearizations * vector : 0;
  const double unsolved = merged && !parts.keeps_gram ? grams - parts.gram : 0;
  const double solving = kept + kept_grams + (3 + (summed ? 1 : 0)) * vector + std::max(measured, unsolved);
  // A trial, and what it would move. After a step that was refused blocks are measured again.
  const double trying = kept + kept_grams + 2 * vector + passing.cost;
  const double again = kept + kept_grams + (parts.keeps_gram ? 0 : passing.gram);
  return views_bytes * (views > 0 ? held / views : 0) + 2 * linearizations * kImageBytes * scene.Largest().pixels +
         always + std::max({linearizing, prepared, solving, trying, again});
}

}  // namespace vesta::gs
