#include "splatting/render/path_through.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/projection/camera_motion.h"
#include "kernels/math/quaternion.h"

namespace vesta::gs {
namespace {

// Centre, then quaternion.
using Pose = Eigen::Matrix<double, 7, 1>;

// Of the two quaternions of its rotation that on the side of `before`.
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

// A cubic spline through points at knots that grow.
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

double StepBetween(const View& from, const View& to, double length_unit) {
  const auto a = CameraCenter(from), b = CameraCenter(to);
  const double way = std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]) / length_unit;
  const double angle =
      splat::MotionBetween(from.rotation.data(), from.translation.data(), to.rotation.data(), to.translation.data())
          .Angle();
  return std::hypot(way, angle);
}

std::vector<View> PathThrough(const std::vector<View>& keys, double length_unit, const Camera& camera, int frames) {
  // Between cameras at one place that look one way.
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
