#include "problems/gaussian_splatting/cameras/gauge.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/camera_motion.h"

namespace vesta::gs {
namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
constexpr int kSimilarity = 7;  // turn, shift, growth
using Vector7 = Eigen::Matrix<double, kSimilarity, 1>;

struct Pose {
  Matrix3 R;
  Vector3 T;
  Vector3 Centre() const { return -R.transpose() * T; }
};

Pose PoseOf(const View& view) {
  return {Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(view.rotation.data()),
          Eigen::Map<const Vector3>(view.translation.data())};
}
Eigen::Quaterniond TurnOf(const splat::CameraMotion& motion) {
  return {motion.quaternion[0], motion.quaternion[1], motion.quaternion[2], motion.quaternion[3]};
}
Pose Moved(const Pose& pose, const splat::CameraMotion& motion) {
  const Matrix3 Q = TurnOf(motion).toRotationMatrix();
  return {Q * pose.R, Q * pose.T + Eigen::Map<const Vector3>(motion.translation)};
}
splat::CameraMotion MotionBetween(const View& from, const Pose& to) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = to.R;
  return splat::MotionBetween(from.rotation.data(), from.translation.data(), R.data(), to.T.data());
}
// The rotation vector of a turn.
Vector3 LogOf(const Eigen::Quaterniond& q) {
  const Eigen::AngleAxisd turn(q);
  return turn.angle() * turn.axis();
}
Matrix3 CrossMatrix(const Vector3& v) {
  Matrix3 m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

}  // namespace

void RemoveCommonMotion(const std::vector<const View*>& given, double depth, std::vector<ViewUnknowns>* found) {
  VESTA_CHECK(given.size() == found->size(), "{} views, but {} that were found", given.size(), found->size());
  if (given.empty()) return;
  const auto views = static_cast<double>(given.size());
  Vector3 middle = Vector3::Zero();
  for (const View* view : given) middle += PoseOf(*view).Centre() / views;

  Eigen::Matrix<double, kSimilarity, kSimilarity> normal = decltype(normal)::Zero();
  Vector7 right = Vector7::Zero();
  const auto add = [&](const Eigen::Matrix<double, 3, kSimilarity>& rows, const Vector3& value) {
    normal += rows.transpose() * rows;
    right += rows.transpose() * value;
  };
  for (std::size_t i = 0; i < given.size(); ++i) {
    const splat::CameraMotion& motion = (*found)[i].motion;
    const Pose pose = PoseOf(*given[i]);
    const Vector3 arm = pose.Centre() - middle;
    // Turned by Q in its own axes, the camera turns by R^T Q^T R in the world.
    const Vector3 turned = -(pose.R.transpose() * LogOf(TurnOf(motion)));
    Eigen::Matrix<double, 3, kSimilarity> rows = decltype(rows)::Zero();
    rows.leftCols<3>() = depth * Matrix3::Identity();
    add(rows, depth * turned);
    rows.leftCols<3>() = -CrossMatrix(arm);
    rows.middleCols<3>(3) = Matrix3::Identity();
    rows.col(6) = arm;
    add(rows, Moved(pose, motion).Centre() - pose.Centre());
  }
  // By its pseudo-inverse: a freedom of which nothing is known stays.
  const Vector7 common = normal.completeOrthogonalDecomposition().solve(right);
  const Vector3 turn = common.head<3>(), shift = common.segment<3>(3);
  if (!common.allFinite() || common[6] <= -1) return;
  const Matrix3 back = Eigen::AngleAxisd(-turn.norm(), turn.stableNormalized()).toRotationMatrix();
  for (std::size_t i = 0; i < given.size(); ++i) {
    Pose moved = Moved(PoseOf(*given[i]), (*found)[i].motion);
    const Vector3 centre = middle + back * (moved.Centre() - middle - shift) / (1 + common[6]);
    moved.R = moved.R * back.transpose();
    moved.T = -moved.R * centre;
    (*found)[i].motion = MotionBetween(*given[i], moved);
  }
}

void RemoveCommonExposure(std::vector<ViewUnknowns>* found) {
  if (found->empty()) return;
  const auto views = static_cast<double>(found->size());
  for (std::size_t c = 0; c < 3; ++c) {
    double gain = 0, offset = 0;
    for (const ViewUnknowns& view : *found) gain += view.color.gain[c] / views, offset += view.color.offset[c] / views;
    if (!(gain > 0)) continue;
    for (ViewUnknowns& view : *found) {
      view.color.gain[c] /= gain;
      view.color.offset[c] -= view.color.gain[c] * offset;
    }
  }
}

}  // namespace vesta::gs
