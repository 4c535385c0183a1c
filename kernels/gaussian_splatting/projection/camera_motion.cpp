// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/projection/camera_motion.h"

#include <algorithm>
#include <cmath>

#include "kernels/math/quaternion.h"

namespace vesta::splat {
namespace {

// out = A v, row-major.
void Apply(const double A[9], const double v[3], double out[3]) {
  for (int i = 0; i < 3; ++i) out[i] = A[3 * i] * v[0] + A[3 * i + 1] * v[1] + A[3 * i + 2] * v[2];
}

}  // namespace

double CameraMotion::Angle() const {
  const double* q = quaternion;
  return 2 * std::atan2(std::hypot(q[1], q[2], q[3]), std::abs(q[0]));
}

CameraMotion Compose(const PoseTangent& xi, const CameraMotion& motion) {
  const double half[3] = {0.5 * xi.v[0], 0.5 * xi.v[1], 0.5 * xi.v[2]};
  double turn[4], product[4], R[9];
  QuaternionExponential(half, turn);
  QuaternionProduct(turn, motion.quaternion, product);
  RotationFromQuaternion(turn, R);
  CameraMotion composed;
  NormalizeQuaternion(product, composed.quaternion);
  Apply(R, motion.translation, composed.translation);
  for (int i = 0; i < 3; ++i) composed.translation[i] += xi.v[3 + i];
  return composed;
}

CameraMotion MotionBetween(const double R[9], const double T[3], const double to_R[9], const double to_T[3]) {
  double turn[9] = {}, turned[3], q[4];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) turn[3 * i + j] += to_R[3 * i + k] * R[3 * j + k];
    }
  }
  QuaternionFromRotation(turn, q);
  CameraMotion motion;
  NormalizeQuaternion(q, motion.quaternion);
  Apply(turn, T, turned);
  for (int i = 0; i < 3; ++i) motion.translation[i] = to_T[i] - turned[i];
  return motion;
}

void MovePose(const CameraMotion& motion, double R[9], double T[3]) {
  double turn[9], old_R[9], old_T[3];
  RotationFromQuaternion(motion.quaternion, turn);
  std::copy_n(R, 9, old_R);
  std::copy_n(T, 3, old_T);
  for (int k = 0; k < 3; ++k) {
    const double column[3] = {old_R[k], old_R[3 + k], old_R[6 + k]};
    double turned[3];
    Apply(turn, column, turned);
    for (int i = 0; i < 3; ++i) R[3 * i + k] = turned[i];
  }
  Apply(turn, old_T, T);
  for (int i = 0; i < 3; ++i) T[i] += motion.translation[i];
}

PosedCamera Moved(const PosedCamera& camera, const CameraMotion& motion) {
  PosedCamera moved = camera;
  MovePose(motion, moved.R, moved.T);
  // -R^T T of the two poses differs by this vector.
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) moved.centre[i] -= moved.R[3 * j + i] * motion.translation[j];
  }
  return moved;
}

}  // namespace vesta::splat
