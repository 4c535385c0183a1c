#include "splatting/render/spiral.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/core/check.h"
#include "splatting/render/look.h"

namespace vesta::gs {
namespace {

// How far nine tenths of the values are from 0.
double ReachOf(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(0.9 * static_cast<double>(values.size() - 1))];
}

}  // namespace

std::vector<View> SpiralOf(const Scene& scene, const Camera& camera, int frames) {
  constexpr double kLeastAgreement = 0.5;  // within 60 degrees of one direction, if all are as far from it
  VESTA_CHECK(frames > 0, "{} frames", frames);
  const Point3 mean = MeanDirection(scene.views), up = UpOf(scene.views);
  if (Eigen::Vector3d(mean.data()).norm() < kLeastAgreement) {
    Fail(
        "the cameras face different ways, and a spiral is for those that face one; take the path orbit or photographs");
  }
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const View& view : scene.views) middle += Eigen::Vector3d(CameraCenter(view).data());
  middle /= static_cast<double>(scene.views.size());
  const Eigen::Vector3d focus = middle + 2 * scene.extent * Eigen::Vector3d(mean.data()).normalized();
  const auto at = [](const Eigen::Vector3d& v) { return Point3{v[0], v[1], v[2]}; };
  const View average = LookingAt(camera, at(middle), at(focus), up);

  std::vector<double> offsets[3];
  for (const View& view : scene.views) {
    const Point3 offset = InCamera(average, CameraCenter(view));
    for (std::size_t k = 0; k < 3; ++k) offsets[k].push_back(offset[k]);
  }
  // Along the way that all look, no nearer to what they look at than half of the distance.
  const Eigen::Vector3d reach(ReachOf(offsets[0]), ReachOf(offsets[1]), std::min(ReachOf(offsets[2]), scene.extent));
  const Eigen::Matrix3d axes = Eigen::Map<const Eigen::Matrix3d>(average.rotation.data());  // columns, in the world
  std::vector<View> views;
  for (int k = 0; k < frames; ++k) {
    const double turn = 2 * std::numbers::pi * k / frames;
    const Eigen::Vector3d on(std::cos(2 * turn), std::sin(2 * turn), std::sin(turn));
    const Eigen::Vector3d center = middle + axes * reach.cwiseProduct(on);
    views.push_back(LookingAt(camera, at(center), at(focus), up));
  }
  return views;
}

}  // namespace vesta::gs
