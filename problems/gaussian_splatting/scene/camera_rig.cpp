// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/scene/camera_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/gaussian_splatting/lenses/models.h"

namespace vesta::gs {

CameraSpread SpreadOf(const std::vector<const View*>& views) {
  CameraSpread spread;
  std::vector<std::array<double, 3>> centers;
  centers.reserve(views.size());
  for (const View* view : views) centers.push_back(CameraCenter(*view));
  std::array<double, 3>& mean = spread.mean;
  for (const auto& center : centers) {
    for (std::size_t i = 0; i < 3; ++i) mean[i] += center[i] / static_cast<double>(centers.size());
  }
  for (const auto& center : centers) {
    spread.radius = std::max(spread.radius, std::hypot(center[0] - mean[0], center[1] - mean[1], center[2] - mean[2]));
  }
  return spread;
}

std::array<double, 3> SumOfUps(const std::vector<View>& views) {
  std::array<double, 3> up{};
  for (const View& view : views) {
    for (std::size_t i = 0; i < 3; ++i) up[i] -= view.rotation[3 + i];
  }
  return up;
}

double HorizontalAngle(const Camera& camera) {
  double t[3];
  splat::PointAt(camera.lens, camera.lens.cx + 0.5 * camera.width, camera.lens.cy, 1, t);
  return 2 * std::atan2(t[0], t[2]) * 180 / std::numbers::pi;
}

}  // namespace vesta::gs
