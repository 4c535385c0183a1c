// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/training/evidence.h"

#include <fmt/format.h>

#include <cmath>

#include "problems/gaussian_splatting/scene/camera_rig.h"
#include "splatting/cameras/alignment/align_view.h"

namespace vesta::gs {
namespace {

// Parts of the loss, and of the error.
constexpr double kPoseGain = 0.1, kExposureGain = 0.05;

AlignedEvaluation Fit(const SplatModel& model, const Scene& scene, AlignOptions options, bool color) {
  options.free.color = color;
  return EvaluateAligned(model, scene, options);
}

}  // namespace

CameraChoice CameraEvidence::Choice() const { return pose >= kPoseGain ? CameraChoice::kPose : CameraChoice::kNone; }

std::string CameraEvidence::Words() const {
  return fmt::format(
      "{} views that were held back lose {:.1f} % of their loss, {:.0f} were asked for, by moving their cameras {:.2f} "
      "pixels{}",
      views, 100 * pose, 100 * kPoseGain, pixels,
      exposure < kExposureGain
          ? ""
          : fmt::format("; and {:.0f} % of the error by exposures, which pose+exposure would find: the "
                        "photographs seem to differ",
                        100 * exposure));
}

CameraEvidence EvidenceOf(const SplatModel& model, const std::vector<View>& views,
                          const std::array<double, 3>& background, double near) {
  Scene scene;
  scene.views = views;
  for (View& view : scene.views) view.role = ViewRole::kTest;
  AlignOptions options;
  options.background = background, options.near = near;
  const AlignedEvaluation moved = Fit(model, scene, options, false), exposed = Fit(model, scene, options, true);
  CameraEvidence evidence;
  std::vector<double> gains;
  for (const AlignedView& view : moved.views) {
    const Alignment& alignment = view.alignment;
    gains.push_back(alignment.is_found() ? 1 - alignment.cost_after / alignment.cost_before : 0);
  }
  evidence.views = static_cast<int>(views.size());
  if (views.empty()) return evidence;
  evidence.pose = Median(std::move(gains));
  evidence.pixels = moved.pixels;
  if (exposed.right.views > 0) {
    evidence.exposure = 1 - std::pow(10, (exposed.right.psnr - exposed.right_exposed.psnr) / 20);
  }
  return evidence;
}

}  // namespace vesta::gs
