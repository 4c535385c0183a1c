#include "problems/gaussian_splatting/memory/stage_bytes.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/jacobian_cache.h"
#include "kernels/gaussian_splatting/view.h"
#include "kernels/image/image_kernels.h"
#include "problems/gaussian_splatting/lm/view_batches.h"
#include "problems/gaussian_splatting/memory/engine_bytes.h"

namespace vesta::gs {
namespace {

// A splat::View<float>.
double ViewBytes(const ViewCounts& view, Index gaussians) {
  const double offsets = sizeof(std::int64_t), index = sizeof(std::uint32_t);
  return view.splats * (sizeof(splat::Splat<float>) + offsets) + index * static_cast<double>(gaussians) +
         view.tiles * offsets + 3 * index * view.pairs;
}

// The parts of a splat::ViewWorkspace<float> that projecting, J^T, and Gram matrices need.
double ProjectBytes(const ViewCounts& view, Index gaussians) {
  return static_cast<double>(gaussians) * (sizeof(std::uint32_t) + sizeof(splat::Splat<float>)) +
         2 * sizeof(KeyValue) * view.splats;
}
double SumBytes(const ViewCounts& view, std::size_t record) {
  return (view.splats + view.pairs) * static_cast<double>(record);
}

// What PhotometricLoss<float> works in, all its objects together: scratch rows for each thread (an image is taken to be
// up to twice as wide as high).
double LossBytes(const ViewCounts& view) {
  const auto width = static_cast<int>(std::sqrt(2 * view.pixels));
  return sizeof(float) * NumThreads() * static_cast<double>(RowRange<float>::kScratchRows * ScratchStride(width));
}

// What an evaluation needs while a stage is under way: a renderer, which stays; and its image, and the meters.
double RendererBytes(const ViewCounts& view, Index gaussians) {
  return ViewBytes(view, gaussians) + ProjectBytes(view, gaussians);
}
double MetersBytes(const ViewCounts& view) { return 3 * kImageBytes * view.pixels + LossBytes(view); }
double EvaluationBytes(const ViewCounts& view, Index gaussians) {
  return RendererBytes(view, gaussians) + MetersBytes(view);
}

double CacheBytes(const ViewCounts& view, const LmStageOptions& lm) {
  if (!IsCached(lm.jacobian)) return 0;
  const auto format = lm.jacobian == JacobianKind::kCache32 ? splat::CacheFormat::kFull : splat::CacheFormat::kHalf;
  return static_cast<double>(
      splat::JacobianCache<float>::NumBytes(static_cast<Index>(view.entries), static_cast<Index>(view.pairs), format));
}

double LinearizedViewBytes(const ViewCounts& view, Index gaussians, const LmStageOptions& lm) {
  // The image, and those of its loss.
  return ViewBytes(view, gaussians) + (1 + LossImages(lm)) * kImageBytes * view.pixels + CacheBytes(view, lm);
}

}  // namespace

double AdamBytes(const MemoryScene& scene, const StageOptions& options) {
  const bool density = options.density.enabled;
  const ViewCounts most = scene.Largest();
  const Index n = scene.gaussians;
  const double vector = VectorBytes(scene), bases = BasesBytes(scene, options.adam);
  // The model, its gradient, two moments and the bases; while Gaussians are rearranged one vector is there twice, later
  // there is the mean of the parameters.
  return 4 * vector + bases + (density || options.adam.average_part > 0 ? vector : 0) +
         (density ? 3 : 1) * PerGaussianBytes(scene) + ViewBytes(most, n) + ProjectBytes(most, n) +
         SumBytes(most, sizeof(splat::SplatTangent<float>)) + 2 * kImageBytes * most.pixels + EvaluationBytes(most, n);
}

double LmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches) {
  const ViewCounts most = scene.Largest();
  const Index n = scene.gaussians;
  double views_bytes = 0;
  for (const ViewCounts& view : scene.views) views_bytes += LinearizedViewBytes(view, n, lm);
  double rebuilt = 0;
  if (lm.jacobian == JacobianKind::kRebuild) {
    // One view for each linearization that is held.
    const Index batches = ViewBatches::CutCount(lm.batches, lm.batch_size, static_cast<Index>(scene.views.size()));
    rebuilt = (hold_batches ? static_cast<double>(batches) : 1) * LinearizedViewBytes(most, n, lm);
    views_bytes = 0;
  }
  double workspace = ProjectBytes(most, n) + SumBytes(most, sizeof(splat::SplatTangent<float>));
  if (IsCached(lm.jacobian)) workspace += kImageBytes * splat::kTileSize * splat::kTileSize * most.tiles;
  const PassingBytes passing{.gram = SumBytes(most, sizeof(splat::SplatGram<float>)),
                             .cost = ViewBytes(most, n) + kImageBytes * most.pixels,
                             .evaluation = MetersBytes(most)};
  return EngineBytes(scene, lm, hold_batches, views_bytes, passing) + PerGaussianBytes(scene) + rebuilt + workspace +
         RendererBytes(most, n);
}

double ModelBytes(const MemoryScene& scene) {
  return VectorBytes(scene) + EvaluationBytes(scene.Largest(), scene.gaussians);
}

}  // namespace vesta::gs
