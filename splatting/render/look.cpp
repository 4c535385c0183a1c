// SPDX-License-Identifier: Apache-2.0
#include "splatting/render/look.h"

#include <Eigen/Dense>

#include "kernels/core/check.h"

namespace vesta::gs {
namespace {

using Vector = Eigen::Vector3d;

Vector Of(const Point3& p) { return {p[0], p[1], p[2]}; }
Point3 Of(const Vector& v) { return {v[0], v[1], v[2]}; }

// Row i of the rotation: 0 right, 1 down, 2 forward.
Vector AxisOf(const View& view, std::size_t i) {
  const auto& r = view.rotation;
  return {r[3 * i], r[3 * i + 1], r[3 * i + 2]};
}

Vector MeanAxis(const std::vector<View>& views, std::size_t i) {
  VESTA_CHECK(!views.empty(), "a scene without views has no path");
  Vector sum = Vector::Zero();
  for (const View& view : views) sum += AxisOf(view, i);
  return sum / static_cast<double>(views.size());
}

// If the mean direction is shorter, there is no common direction.
constexpr double kLeastAgreement = 0.3;

}  // namespace

View LookingAt(const Camera& camera, const Point3& center, const Point3& target, const Point3& up) {
  const Vector forward = (Of(target) - Of(center)).normalized();
  Vector right = forward.cross(Of(up));
  if (right.norm() < 1e-9 * Of(up).norm()) right = forward.unitOrthogonal();
  right.normalize();
  const Vector down = forward.cross(right);
  View view;
  view.camera = camera;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    view.rotation[i] = right[k], view.rotation[3 + i] = down[k], view.rotation[6 + i] = forward[k];
  }
  const Vector c = Of(center);
  view.translation = {-right.dot(c), -down.dot(c), -forward.dot(c)};
  return view;
}

Point3 MeanDirection(const std::vector<View>& views) { return Of(MeanAxis(views, 2)); }

Point3 UpOf(const std::vector<View>& views) {
  // Weight of the mean up vector relative to all views: a few degrees of roll.
  constexpr double kPrior = 0.01;
  Vector mean = -MeanAxis(views, 1);
  if (mean.norm() < kLeastAgreement) mean = -MeanAxis(views, 2);
  if (mean.norm() < kLeastAgreement) mean = -AxisOf(views.front(), 1);
  Eigen::Matrix3d normal = kPrior * Eigen::Matrix3d::Identity();
  for (const View& view : views) {
    const Vector right = AxisOf(view, 0);
    normal += right * right.transpose() / static_cast<double>(views.size());
  }
  return Of(Vector(normal.ldlt().solve(mean).normalized()));
}

Point3 PointLookedAt(const Scene& scene) {
  // Weight of the median depth relative to an optical axis.
  constexpr double kPrior = 1e-3;
  Vector middle = Vector::Zero();
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Vector right_side = Vector::Zero();
  const Vector mean = MeanAxis(scene.views, 2);
  for (const View& view : scene.views) {
    const Vector center = Of(CameraCenter(view)), axis = AxisOf(view, 2);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    normal += across;
    right_side += across * center;
    middle += center;
  }
  const auto count = static_cast<double>(scene.views.size());
  const Vector usual = middle / count + 2 * scene.extent * mean;
  normal += kPrior * count * Eigen::Matrix3d::Identity();
  right_side += kPrior * count * usual;
  return Of(Vector(normal.ldlt().solve(right_side)));
}

}  // namespace vesta::gs
