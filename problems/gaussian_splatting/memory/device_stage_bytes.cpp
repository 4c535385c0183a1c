#include "problems/gaussian_splatting/memory/device_stage_bytes.h"

#include <algorithm>

#include "kernels/gaussian_splatting/device_cache.h"
#include "kernels/gaussian_splatting/types.h"
#include "problems/gaussian_splatting/lm/view_batches.h"
#include "problems/gaussian_splatting/memory/engine_bytes.h"

namespace vesta::gs {
namespace {

constexpr double kIndex = sizeof(std::int64_t), kWord = sizeof(std::uint32_t);
// What DeviceView takes to spare for lists that views share.
constexpr double kSpare = 1.125;
// Of CUB's sort, for each thing sorted: counters of the digits in each piece of some thousand. Estimated.
constexpr double kSort = 0.25;

double TargetBytes(const MemoryScene& scene) {
  double pixels = 0;
  for (const ViewCounts& view : scene.views) pixels += view.pixels;
  return kImageBytes * pixels;
}

// A splat::DeviceView.
double ViewBytes(const ViewCounts& view, const MemoryScene& scene) {
  return view.splats * (sizeof(splat::Splat<float>) + kIndex) + PerGaussianBytes(scene) + view.tiles * kIndex +
         2 * kWord * view.pairs;
}

double CacheBytes(const ViewCounts& view, const LmStageOptions& lm) {
  if (!IsCached(lm.jacobian)) return 0;
  const auto format = lm.jacobian == JacobianKind::kCache32 ? splat::CacheFormat::kFull : splat::CacheFormat::kHalf;
  return static_cast<double>(
      splat::DeviceJacobianCache::NumBytes(static_cast<Index>(view.entries), static_cast<Index>(view.pairs), format));
}

// Sums of records by splat and pair.
double SumBytes(const ViewCounts& view, std::size_t record) {
  return kSpare * (view.splats + view.pairs) * static_cast<double>(record);
}

// A splat::DeviceViewWorkspace: keys and indices twice by Gaussian, five lists by pair, and the sums of J^T; without
// those of the Gram matrices.
double WorkspaceBytes(const ViewCounts& view, const MemoryScene& scene) {
  const auto gaussians = static_cast<double>(scene.gaussians);
  return kSpare * (gaussians * (4 * kWord + sizeof(splat::Splat<float>)) + 5 * kWord * view.pairs) +
         SumBytes(view, sizeof(splat::SplatTangent<float>)) + kIndex * view.splats +
         kSort * std::max(gaussians, view.pairs);
}

// What an evaluation needs beside the workspace that is there: a view, its image and truth.
double EvaluationBytes(const ViewCounts& view, const MemoryScene& scene) {
  return ViewBytes(view, scene) + 2 * kImageBytes * view.pixels;
}

}  // namespace

double DeviceAdamBytes(const MemoryScene& scene, const StageOptions& options) {
  const ViewCounts most = scene.Largest();
  const double vector = VectorBytes(scene), bases = BasesBytes(scene, options.adam);
  // Units, pulls and observations by Gaussian.
  const double held = TargetBytes(scene) + 3 * vector + bases + 3 * PerGaussianBytes(scene);
  // The gradient; the image, its gradient and the three slopes of the loss.
  const double step = vector + ViewBytes(most, scene) + WorkspaceBytes(most, scene) + 5 * kImageBytes * most.pixels +
                      EvaluationBytes(most, scene);
  const double average = options.adam.average_part > 0 ? vector : 0;
  // Bases or a vector once more; sources and fates.
  const double rearranging = options.density.enabled ? std::max(vector, bases) + 1.25 * PerGaussianBytes(scene) : 0;
  return held + std::max(step + average, rearranging);
}

double DeviceLmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches) {
  const ViewCounts most = scene.Largest();
  // Each with its image and those of its loss.
  const auto linearized = [&](const ViewCounts& view) {
    return ViewBytes(view, scene) + (1 + LossImages(lm)) * kImageBytes * view.pixels + CacheBytes(view, lm);
  };
  double views_bytes = 0, rebuilt = 0;
  if (lm.jacobian == JacobianKind::kRebuild) {
    // One view for each linearization that is held.
    const Index batches = ViewBatches::CutCount(lm.batches, lm.batch_size, static_cast<Index>(scene.views.size()));
    rebuilt = (hold_batches ? static_cast<double>(batches) : 1) * linearized(most);
  } else {
    for (const ViewCounts& view : scene.views) views_bytes += linearized(view);
  }
  // Of a cache entries are counted pair by pair, where else splats' tiles are.
  const double counts = !IsCached(lm.jacobian) ? 0 : kIndex * std::max(0.0, most.pairs - most.splats);
  // By the centre the loss has neither slopes nor what W blurs.
  const int loss_images = lm.ssim == SsimLinearization::kRootCenter ? 0 : 4;
  // Units by Gaussian; three slopes of the loss and what W blurs. The view and image of a trial's cost are there for a
  // while, as are those of the evaluation.
  const PassingBytes passing{.gram = SumBytes(most, sizeof(splat::SplatGram<float>)),
                             .cost = ViewBytes(most, scene) + kImageBytes * most.pixels,
                             .evaluation = EvaluationBytes(most, scene)};
  return TargetBytes(scene) + EngineBytes(scene, lm, hold_batches, views_bytes, passing) + PerGaussianBytes(scene) +
         rebuilt + WorkspaceBytes(most, scene) + counts + loss_images * kImageBytes * most.pixels;
}

}  // namespace vesta::gs
