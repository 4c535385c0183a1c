#include "problems/gaussian_splatting/train/device_stage_bytes.h"

#include <algorithm>

#include "kernels/gaussian_splatting/types.h"
#include "problems/gaussian_splatting/train/engine_bytes.h"

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

// A splat::DeviceViewWorkspace: keys and indices twice by Gaussian, five lists by pair; the sums of J^T, and where
// `gram` those of the Gram matrices.
double WorkspaceBytes(const ViewCounts& view, const MemoryScene& scene, bool gram) {
  const auto gaussians = static_cast<double>(scene.gaussians);
  const double record = sizeof(splat::SplatTangent<float>) + (gram ? sizeof(splat::SplatGram<float>) : 0);
  return kSpare * (gaussians * (4 * kWord + sizeof(splat::Splat<float>)) + 5 * kWord * view.pairs +
                   (view.splats + view.pairs) * record) +
         kIndex * view.splats + kSort * std::max(gaussians, view.pairs);
}

}  // namespace

double DeviceAdamBytes(const MemoryScene& scene, bool /*density*/) {
  const ViewCounts most = scene.Largest();
  // Units, pulls and observations by Gaussian; the image, its gradient and the three slopes of the loss.
  return TargetBytes(scene) + 4 * VectorBytes(scene) + 3 * PerGaussianBytes(scene) + ViewBytes(most, scene) +
         WorkspaceBytes(most, scene, false) + 5 * kImageBytes * most.pixels;
}

double DeviceLmBytes(const MemoryScene& scene, const LmOptions& lm, bool hold_batches) {
  const ViewCounts most = scene.Largest();
  double views_bytes = 0;
  // Each with its image and the two of its quadratic.
  for (const ViewCounts& view : scene.views) views_bytes += ViewBytes(view, scene) + 3 * kImageBytes * view.pixels;
  // Units and ones by Gaussian; the view and image of the cost; three slopes of the loss and what W blurs.
  return TargetBytes(scene) + EngineBytes(scene, lm, hold_batches, views_bytes) + 2 * PerGaussianBytes(scene) +
         WorkspaceBytes(most, scene, true) + ViewBytes(most, scene) + 5 * kImageBytes * most.pixels;
}

}  // namespace vesta::gs
