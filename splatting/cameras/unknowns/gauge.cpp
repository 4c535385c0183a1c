// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/unknowns/gauge.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/core/check.h"
#include "splatting/cameras/unknowns/moved_view.h"

namespace vesta::gs {
namespace {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
constexpr int kSimilarity = 7;  // rotation, translation, scale
using Vector7 = Eigen::Matrix<double, kSimilarity, 1>;

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
Matrix3 RotationOf(const View& view) { return Eigen::Map<const RowMajor3>(view.rotation.data()); }
Vector3 CentreOf(const View& view) { return Vector3(CameraCenter(view).data()); }
// The rotation vector of a motion.
Vector3 LogOf(const splat::CameraMotion& motion) {
  const double* q = motion.quaternion;
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(q[0], q[1], q[2], q[3]));
  return turn.angle() * turn.axis();
}
// Rotation, and shift of the centre, in world axes.
struct WorldMotion {
  Vector3 turn, shift;
};
WorldMotion InTheWorld(const View& given, const splat::CameraMotion& motion) {
  // A rotation Q in camera axes is R^T Q^T R in world axes.
  return {-(RotationOf(given).transpose() * LogOf(motion)), CentreOf(MovedView(given, motion)) - CentreOf(given)};
}
Matrix3 RotationBy(const Vector3& turn) {
  return Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()).toRotationMatrix();
}
// The motion after a rotation `turn` in the world, with the view's centre at `centre`.
splat::CameraMotion Placed(const View& given, const splat::CameraMotion& found, const Matrix3& turn,
                           const Vector3& centre) {
  View moved = MovedView(given, found);
  const RowMajor3 R = RotationOf(moved) * turn.transpose();
  std::copy_n(R.data(), 9, moved.rotation.data());
  Eigen::Map<Vector3>(moved.translation.data()) = -R * centre;
  return MotionBetween(given, moved);
}
Matrix3 CrossMatrix(const Vector3& v) {
  Matrix3 m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

}  // namespace

void FixCameraGauge(const std::vector<const View*>& given, double depth, std::vector<ViewUnknowns>* found) {
  VESTA_CHECK(given.size() == found->size(), "{} given views, but {} found ones", given.size(), found->size());
  if (given.empty()) return;
  const auto views = static_cast<double>(given.size());
  Vector3 middle = Vector3::Zero();
  for (const View* view : given) middle += CentreOf(*view) / views;

  // The scale follows from the distances between camera centres. If these are small, as in a panorama, other motions
  // would determine the estimate.
  constexpr double kFarApart = 2;  // ratio of root mean squares
  std::vector<WorldMotion> motions;
  Vector3 mean_shift = Vector3::Zero();
  for (std::size_t i = 0; i < given.size(); ++i) {
    motions.push_back(InTheWorld(*given[i], (*found)[i].motion));
    mean_shift += motions[i].shift / views;
  }
  double arms = 0, shifts = 0;
  for (std::size_t i = 0; i < given.size(); ++i) {
    arms += (CentreOf(*given[i]) - middle).squaredNorm();
    shifts += (motions[i].shift - mean_shift).squaredNorm();
  }
  const bool has_grown = arms > kFarApart * kFarApart * shifts;

  Eigen::Matrix<double, kSimilarity, kSimilarity> normal = decltype(normal)::Zero();
  Vector7 right = Vector7::Zero();
  const auto add = [&](const Eigen::Matrix<double, 3, kSimilarity>& rows, const Vector3& value) {
    normal += rows.transpose() * rows;
    right += rows.transpose() * value;
  };
  for (std::size_t i = 0; i < given.size(); ++i) {
    const View& view = *given[i];
    const WorldMotion& motion = motions[i];
    const Vector3 arm = CentreOf(view) - middle;
    Eigen::Matrix<double, 3, kSimilarity> rows = decltype(rows)::Zero();
    rows.leftCols<3>() = depth * Matrix3::Identity();
    add(rows, depth * motion.turn);
    rows.leftCols<3>() = -CrossMatrix(arm);
    rows.middleCols<3>(3) = Matrix3::Identity();
    if (has_grown) rows.col(6) = arm;
    add(rows, motion.shift);
  }
  // The pseudo-inverse leaves undetermined numbers at zero.
  const Vector7 common = normal.completeOrthogonalDecomposition().solve(right);
  const Vector3 turn = common.head<3>(), shift = common.segment<3>(3);
  if (!common.allFinite() || common[6] <= -1) return;
  const Matrix3 back = RotationBy(-turn);
  for (std::size_t i = 0; i < given.size(); ++i) {
    splat::CameraMotion& motion = (*found)[i].motion;
    const Vector3 arm = CentreOf(MovedView(*given[i], motion)) - middle - shift;
    motion = Placed(*given[i], motion, back, middle + back * arm / (1 + common[6]));
  }
}

void SubtractMeanRotation(std::vector<ViewUnknowns>* found) {
  if (found->empty()) return;
  Vector3 mean = Vector3::Zero();
  for (const ViewUnknowns& view : *found) mean += LogOf(view.motion) / static_cast<double>(found->size());
  if (!mean.allFinite()) return;
  splat::PoseTangent back;
  for (int k = 0; k < 3; ++k) back.v[k] = -mean[k];
  for (ViewUnknowns& view : *found) view.motion = splat::Compose(back, view.motion);
}

void FixExposureGauge(std::vector<ViewUnknowns>* found) {
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

std::vector<double> ViewPrior::Residuals(const ViewUnknowns& view, const FreeUnknowns& free, Index values) const {
  const double root = std::sqrt(weight * static_cast<double>(values));
  std::vector<double> r;
  if (free.pose) {
    for (int k = 0; k < 3; ++k) r.push_back(root * 2 * view.motion.quaternion[1 + k]);
    for (const double t : view.motion.translation) r.push_back(root * t / depth);
  }
  if (free.color) {
    for (const double gain : view.color.gain) r.push_back(root * (gain - 1));
    for (const double offset : view.color.offset) r.push_back(root * offset);
  }
  return r;
}

std::vector<double> ViewPrior::Jacobian(const ViewUnknowns& view, const FreeUnknowns& free, Index values) const {
  const double root = std::sqrt(weight * static_cast<double>(values));
  const int n = free.num_tangent(), pose = free.pose_tangent();
  const auto side = static_cast<std::size_t>(n);
  std::vector<double> J(side * side);
  const auto at = [&](int row, int col) -> double& {
    return J[static_cast<std::size_t>(row) * side + static_cast<std::size_t>(col)];
  };
  if (free.pose) {
    // Under exp(omega) from the left, 2 v changes by w omega + omega x v, and t by omega x t + tau.
    const double *q = view.motion.quaternion, *t = view.motion.translation;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      at(i, i) = root * q[0];
      at(i, j) = root * q[1 + k], at(i, k) = -root * q[1 + j];
      at(3 + i, j) = root * t[k] / depth, at(3 + i, k) = -root * t[j] / depth;
      at(3 + i, 3 + i) = root / depth;
    }
  }
  for (int i = pose; i < n; ++i) at(i, i) = root;
  return J;
}

}  // namespace vesta::gs
