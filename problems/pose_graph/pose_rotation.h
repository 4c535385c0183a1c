// SPDX-License-Identifier: Apache-2.0
// The rotation matrix of a 2D or 3D pose. D: 2 or 3. Poses have the form of PoseGraph::poses.
#pragma once

#include <Eigen/Dense>
#include <cmath>

#include "kernels/math/quaternion.h"

namespace vesta::pose_graph {

template <int D>
using Rotation = Eigen::Matrix<double, D, D, Eigen::RowMajor>;

template <int D>
Rotation<D> RotationOf(const double* pose) {
  Rotation<D> rotation;
  if constexpr (D == 2) {
    rotation = Eigen::Rotation2Dd(pose[2]).toRotationMatrix();
  } else {
    RotationFromQuaternion(pose + 3, rotation.data());
  }
  return rotation;
}

template <int D>
void SetRotation(const Rotation<D>& rotation, double* pose) {
  if constexpr (D == 2) {
    pose[2] = std::atan2(rotation(1, 0), rotation(0, 0));
  } else {
    QuaternionFromRotation(rotation.data(), pose + 3);
  }
}

// The nearest rotation in the Frobenius norm.
template <int D>
Rotation<D> NearestRotation(const Rotation<D>& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix<double, D, D>> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix<double, D, D> u = svd.matrixU();
  if (u.determinant() * svd.matrixV().determinant() < 0) u.col(D - 1) *= -1;
  return u * svd.matrixV().transpose();
}

}  // namespace vesta::pose_graph
