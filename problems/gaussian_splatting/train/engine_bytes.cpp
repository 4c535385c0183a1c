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

// Values of the preconditioner's blocks (BlockDiagonal), 0 for Jacobi.
double BlockValues(const MemoryScene& scene, const std::string& preconditioner) {
  const int coefficients = ShCoefficients(scene.sh_degree);
  if (preconditioner == "jacobi") return 0;
  const int colors = preconditioner == "block_sh" ? Packed(coefficients) : 3 * coefficients;
  return static_cast<double>(scene.gaussians) * (Packed(splat::kGeometry) + colors);
}

// A linearization of a batch, without its views.
double LinearizationBytes(const MemoryScene& scene, const LmOptions& lm) {
  const int coefficients = ShCoefficients(scene.sh_degree);
  const int gram =
      Packed(splat::kGeometry) + 3 * coefficients + (lm.preconditioner == "block_sh" ? Packed(coefficients) : 0);
  return 2 * VectorBytes(scene) + gram * PerGaussianBytes(scene) + 2 * kImageBytes * scene.Largest().pixels;
}

// A NormalSystem: gradient, diagonal, metric, right-hand side and mask; of Jacobi the diagonal and its inverse, else
// the blocks and their factors.
double SystemBytes(const MemoryScene& scene, const LmOptions& lm) {
  const double blocks = BlockValues(scene, lm.preconditioner);
  return (blocks == 0 ? 7 : 5) * VectorBytes(scene) + 2 * sizeof(float) * blocks;
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
                             linearizations * LinearizationBytes(scene, lm) + systems * SystemBytes(scene, lm);
  // The model; x, the trial, two steps; two scales; gradient and diagonal; four of PCG; of several batches one more.
  // Where the model is measured along a step, one to hold H's product with it.
  const bool measured = (batches > 1 && lm.merge_batches) || lm.step_limit != "none";
  const double vectors = 1 + 4 + 2 + 2 + 4 + (batches > 1 ? 1 : 0) + (measured ? linearizations : 0);
  return batch_bytes + vectors * VectorBytes(scene);
}

}  // namespace vesta::gs
