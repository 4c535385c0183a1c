#include "problems/gaussian_splatting/train/engine_bytes.h"

#include <algorithm>
#include <cmath>

#include "kernels/gaussian_splatting/layout.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/lm/view_batches.h"
#include "problems/gaussian_splatting/train/adam.h"
#include "problems/gaussian_splatting/train/block_adam_formula.h"

namespace vesta::gs {
namespace {

constexpr int Packed(int size) { return size * (size + 1) / 2; }

// What the preconditioners of so many linearizations and systems are made of. A linearization measures its Gram
// matrices for the diagonal and holds them until they have become blocks; then there are the blocks and their factors.
// Jacobi never asks for blocks: the matrices stay, beside the diagonal, its inverse, and ones.
double PreconditionerBytes(const MemoryScene& scene, const LmOptions& lm, double linearizations, double systems) {
  const int coefficients = ShCoefficients(scene.sh_degree);
  const bool with_colors = lm.preconditioner == "block_sh";
  const double color_blocks = with_colors ? Packed(coefficients) : 0;
  const double gram = Packed(splat::kGeometry) + 3 * coefficients + color_blocks;
  if (lm.preconditioner == "jacobi") {
    return linearizations * gram * PerGaussianBytes(scene) + 3 * systems * VectorBytes(scene);
  }
  const double blocks = Packed(splat::kGeometry) + (with_colors ? color_blocks : 3 * coefficients);
  return std::max(linearizations * gram + blocks, 2 * systems * blocks) * PerGaussianBytes(scene);
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

double EngineBytes(const MemoryScene& scene, const LmOptions& lm, bool hold_batches, double views_bytes) {
  const auto views = static_cast<double>(scene.views.size());
  const auto batches =
      static_cast<double>(ViewBatches::CutCount(lm.batches, lm.batch_size, static_cast<Index>(scene.views.size())));
  // Views in each batch, up to one more in some than in others.
  const double size = std::ceil(lm.batch_size > 0 ? std::min<double>(lm.batch_size, views) : views / batches);
  const double held = hold_batches ? std::min(batches * size, views) : std::min(size, views);
  const double linearizations = hold_batches ? batches : 1, systems = hold_batches && lm.merge_batches ? batches : 1;
  const double batch_bytes = views_bytes * (views > 0 ? held / views : 0) +
                             2 * linearizations * kImageBytes * scene.Largest().pixels +
                             PreconditionerBytes(scene, lm, linearizations, systems);
  // The gradient of each linearization; of each system descent, diagonal, metric and mask.
  const double batch_vectors = linearizations + 4 * systems;
  // The model, x, the step; four of PCG. Of several batches the sum of their products, or, merged, descent, diagonal
  // and step. Where the model is measured along a step, one to hold H's product with it.
  const bool merged = batches > 1 && lm.merge_batches;
  double engine_vectors = 3 + 4;
  if (batches > 1) engine_vectors += merged ? 3 : 1;
  if (merged || lm.step_limit != "none") engine_vectors += linearizations;
  return batch_bytes + (batch_vectors + engine_vectors) * VectorBytes(scene);
}

}  // namespace vesta::gs
