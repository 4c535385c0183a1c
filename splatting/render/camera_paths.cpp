// SPDX-License-Identifier: Apache-2.0
#include "splatting/render/camera_paths.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/projection/camera_motion.h"
#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/render/look.h"

namespace vesta::gs {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// Widest gap between angles on a circle, radians.
double WidestGap(std::vector<double> angles) {
  std::ranges::sort(angles);
  double widest = angles.front() + kTurn - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) widest = std::max(widest, angles[i] - angles[i - 1]);
  return widest;
}

// The 90th percentile of the absolute values.
double ReachOf(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(0.9 * static_cast<double>(values.size() - 1))];
}

using Order = std::vector<std::size_t>;

class Steps {
 public:
  Steps(const std::vector<View>& views, double length_unit) : views_(views), unit_(length_unit) {}
  double operator()(std::size_t a, std::size_t b) const { return StepBetween(views_[a], views_[b], unit_); }
  double Length(const Order& order) const {
    double sum = 0;
    for (std::size_t i = 1; i < order.size(); ++i) sum += (*this)(order[i - 1], order[i]);
    return sum;
  }

 private:
  const std::vector<View>& views_;
  double unit_;
};

Order ToTheNearest(const Steps& step, Order order) {
  for (std::size_t i = 1; i < order.size(); ++i) {
    std::size_t nearest = i;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = i; k < order.size(); ++k) {
      const double length = step(order[i - 1], order[k]);
      if (length < least) least = length, nearest = k;
    }
    std::swap(order[i], order[nearest]);
  }
  return order;
}

// Reverses sections of the tour while this makes it shorter (2-opt), except the first view.
void Untangle(const Steps& step, Order& order) {
  constexpr int kMostRounds = 8;
  bool is_better = true;
  for (int round = 0; round < kMostRounds && is_better; ++round) {
    is_better = false;
    for (std::size_t i = 1; i + 1 < order.size(); ++i) {
      for (std::size_t k = i + 1; k < order.size(); ++k) {
        const bool is_last = k + 1 == order.size();
        const double now = step(order[i - 1], order[i]) + (is_last ? 0 : step(order[k], order[k + 1]));
        const double then = step(order[i - 1], order[k]) + (is_last ? 0 : step(order[i], order[k + 1]));
        if (then > now - 1e-9) continue;
        std::reverse(order.begin() + static_cast<std::ptrdiff_t>(i),
                     order.begin() + static_cast<std::ptrdiff_t>(k) + 1);
        is_better = true;
      }
    }
  }
}

// Camera centre, then quaternion.
using Pose = Eigen::Matrix<double, 7, 1>;

// Uses q or -q, whichever is closer to `before`.
Pose PoseOf(const View& view, const Pose& before) {
  Pose pose;
  pose.head<3>() = Eigen::Vector3d(CameraCenter(view).data());
  double q[4];
  QuaternionFromRotation(view.rotation.data(), q);
  pose.tail<4>() = Eigen::Vector4d(q);
  if (pose.tail<4>().dot(before.tail<4>()) < 0) pose.tail<4>() *= -1;
  return pose;
}

View ViewAt(const Pose& pose, const Camera& camera) {
  View view;
  view.camera = camera;
  const Eigen::Vector4d q = pose.tail<4>();
  RotationFromQuaternion(q.data(), view.rotation.data());
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      view.translation[i] -= view.rotation[3 * i + j] * pose[static_cast<Eigen::Index>(j)];
    }
  }
  return view;
}

// A cubic spline through points at increasing knots.
class Spline {
 public:
  Spline(std::vector<double> knots, std::vector<Pose> points) : knots_(std::move(knots)), points_(std::move(points)) {
    const std::size_t last = points_.size() - 1;
    const auto secant = [&](std::size_t i) -> Pose {
      return (points_[i + 1] - points_[i]) / (knots_[i + 1] - knots_[i]);
    };
    slopes_.assign(points_.size(), Pose::Zero());
    if (last == 0) return;
    slopes_.front() = secant(0);
    slopes_.back() = secant(last - 1);
    for (std::size_t i = 1; i < last; ++i) {
      const double before = knots_[i] - knots_[i - 1], after = knots_[i + 1] - knots_[i];
      slopes_[i] = (after * secant(i - 1) + before * secant(i)) / (before + after);
    }
  }

  double end() const { return knots_.back(); }

  Pose At(double knot) const {
    if (points_.size() == 1) return points_.front();
    const auto above = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, knot);
    const auto i = static_cast<std::size_t>(above - knots_.begin()) - 1;
    const double length = knots_[i + 1] - knots_[i], t = (knot - knots_[i]) / length, s = 1 - t;
    return s * s * ((1 + 2 * t) * points_[i] + t * length * slopes_[i]) +
           t * t * ((1 + 2 * s) * points_[i + 1] - s * length * slopes_[i + 1]);
  }

 private:
  std::vector<double> knots_;
  std::vector<Pose> points_, slopes_;
};

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

std::vector<View> SpiralOf(const Scene& scene, const Camera& camera, int frames) {
  constexpr double kLeastAgreement = 0.5;  // length of the mean direction; 0.5 if all views are 60 degrees from it
  VESTA_CHECK(frames > 0, "{} frames", frames);
  const Point3 mean = MeanDirection(scene.views), up = UpOf(scene.views);
  if (Eigen::Vector3d(mean.data()).norm() < kLeastAgreement) {
    Fail(kBadArgument,
         "the cameras face different directions, but a spiral needs one direction; use the path orbit or photographs");
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
  // Along the viewing direction, at most half of the distance to the focus.
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

Tour TourOf(const std::vector<View>& views, double length_unit) {
  constexpr double kJumps = 1.5;
  const Steps step(views, length_unit);
  Order given(views.size());
  std::iota(given.begin(), given.end(), std::size_t{0});
  Order other = ToTheNearest(step, given);
  Untangle(step, other);
  if (step.Length(given) <= kJumps * step.Length(other)) return {std::move(given), false};
  return {std::move(other), true};
}

double StepBetween(const View& from, const View& to, double length_unit) {
  const auto a = CameraCenter(from), b = CameraCenter(to);
  const double way = std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]) / length_unit;
  const double angle =
      splat::MotionBetween(from.rotation.data(), from.translation.data(), to.rotation.data(), to.translation.data())
          .Angle();
  return std::hypot(way, angle);
}

std::vector<View> PathThrough(const std::vector<View>& keys, double length_unit, const Camera& camera, int frames) {
  // The least step, for cameras with the same pose.
  constexpr double kLeastStep = 1e-4;
  VESTA_CHECK(!keys.empty() && frames > 0, "{} keys, {} frames", keys.size(), frames);
  std::vector<double> knots{0};
  std::vector<Pose> poses{PoseOf(keys.front(), Pose::Zero())};
  for (std::size_t i = 1; i < keys.size(); ++i) {
    knots.push_back(knots.back() + std::max(kLeastStep, StepBetween(keys[i - 1], keys[i], length_unit)));
    poses.push_back(PoseOf(keys[i], poses.back()));
  }
  const Spline spline(std::move(knots), std::move(poses));
  std::vector<View> views;
  views.reserve(static_cast<std::size_t>(frames));
  for (int k = 0; k < frames; ++k) {
    views.push_back(ViewAt(spline.At(spline.end() * k / std::max(1, frames - 1)), camera));
  }
  return views;
}

}  // namespace vesta::gs
