#include "splatting/render/orbit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/scene/median.h"
#include "splatting/render/look.h"

namespace vesta::gs {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// The widest gap between angles on a circle, radians.
double WidestGap(std::vector<double> angles) {
  std::ranges::sort(angles);
  double widest = angles.front() + kTurn - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) widest = std::max(widest, angles[i] - angles[i - 1]);
  return widest;
}

}  // namespace

Orbit OrbitOf(const Scene& scene, const Camera& camera, int frames) {
  VESTA_CHECK(frames > 0, "{} frames", frames);
  const Point3 at = PointLookedAt(scene), upwards = UpOf(scene.views);
  const Eigen::Vector3d point(at.data()), up(upwards.data());
  const Eigen::Vector3d first = up.unitOrthogonal(), second = up.cross(first);
  std::vector<double> radii, heights, angles;
  for (const View& view : scene.views) {
    const Point3 center = CameraCenter(view);
    const Eigen::Vector3d from = Eigen::Vector3d(center.data()) - point;
    heights.push_back(from.dot(up));
    radii.push_back(from.cross(up).norm());
    angles.push_back(std::atan2(from.dot(second), from.dot(first)));
  }
  const double begin = angles.front(), radius = Median(std::move(radii)), height = Median(std::move(heights));
  Orbit orbit;
  for (int k = 0; k < frames; ++k) {
    const double angle = begin + kTurn * k / frames;
    const Eigen::Vector3d center = point + height * up + radius * (std::cos(angle) * first + std::sin(angle) * second);
    orbit.views.push_back(LookingAt(camera, {center[0], center[1], center[2]}, at, upwards));
  }
  orbit.unseen_degrees = WidestGap(std::move(angles)) * 360 / kTurn;
  return orbit;
}

}  // namespace vesta::gs
