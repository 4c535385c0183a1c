// SPDX-License-Identifier: Apache-2.0
// Conversions between rotation vectors (angle-axis), quaternions and rotation matrices, and rotations of points. Names,
// arguments and memory layouts are as in ceres/rotation.h.
//
// A rotation vector is the axis times the angle in radians. Quaternions are w, x, y, z. T is any scalar type whose
// comparisons return bool: double, Dual, ceres::Jet. Values and first derivatives are accurate to rounding for every
// rotation; Ceres's derivatives have errors of up to 1e-8 near the identity. Ceres's header also has QuaternionProduct
// and CrossProduct; here they come from the included headers.
#pragma once

#include <cmath>

#include "kernels/math/quaternion.h"
#include "kernels/math/rotation_vector.h"

// Calls here are written vesta::F(...), because F(...) with a ceres::Jet could also mean ceres::F (argument-dependent
// lookup). Because of the namespace `rotation`, calls in ceres/rotation.h with a Dual do not find these functions.
namespace vesta {
namespace rotation {}
using namespace rotation;
namespace rotation {

// A 3 x 3 matrix in memory, with entry (row, column) at pointer[row * row_stride + column * col_stride].
template <class T, int row_stride, int col_stride>
struct MatrixAdapter {
  T* pointer;
  VESTA_HD explicit MatrixAdapter(T* values) : pointer(values) {}
  VESTA_HD T& operator()(int row, int column) const { return pointer[row * row_stride + column * col_stride]; }
};
template <class T>
VESTA_HD MatrixAdapter<T, 1, 3> ColumnMajorAdapter3x3(T* pointer) {
  return MatrixAdapter<T, 1, 3>(pointer);
}
template <class T>
VESTA_HD MatrixAdapter<T, 3, 1> RowMajorAdapter3x3(T* pointer) {
  return MatrixAdapter<T, 3, 1>(pointer);
}

template <class T>
VESTA_HD T DotProduct(const T x[3], const T y[3]) {
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

// quaternion: a unit quaternion.
template <class T>
VESTA_HD void AngleAxisToQuaternion(const T* angle_axis, T* quaternion) {
  using std::cos, std::sin, std::sqrt;
  const T square = vesta::DotProduct(angle_axis, angle_axis);
  // At 0 the square root has no derivative; sin(angle / 2) / angle is 1 / 2 there, with derivative 0.
  T factor(0.5);
  quaternion[0] = T(1.0);
  if (square > T(0.0)) {
    const T angle = sqrt(square), half = angle * T(0.5);
    factor = sin(half) / angle;
    quaternion[0] = cos(half);
  }
  for (int i = 0; i < 3; ++i) quaternion[1 + i] = factor * angle_axis[i];
}

// quaternion: not 0; only its direction counts. The angle is at most pi.
template <class T>
VESTA_HD void QuaternionToAngleAxis(const T* quaternion, T* angle_axis) {
  using std::atan2, std::sqrt;
  const T square = vesta::DotProduct(quaternion + 1, quaternion + 1);
  const bool negative = quaternion[0] < T(0.0);
  const T cosine = negative ? -quaternion[0] : quaternion[0];
  // factor = angle / sin(angle / 2). If w < 0, -q is used; it is the same rotation as q.
  T factor = T(2.0) / cosine;
  if (square > T(0.0)) {
    const T sine = sqrt(square);
    factor = T(2.0) * atan2(sine, cosine) / sine;
  }
  if (negative) factor = -factor;
  for (int i = 0; i < 3; ++i) angle_axis[i] = factor * quaternion[1 + i];
}

// R: orthonormal, column-major unless an adapter is given. quaternion: a unit quaternion with w >= 0.
template <class T, int row_stride, int col_stride>
VESTA_HD void RotationMatrixToQuaternion(const MatrixAdapter<const T, row_stride, col_stride>& R, T* quaternion) {
  T rows[9];
  for (int i = 0; i < 9; ++i) rows[i] = R(i / 3, i % 3);
  vesta::QuaternionFromRotation(rows, quaternion);
}
template <class T>
VESTA_HD void RotationMatrixToQuaternion(const T* R, T* quaternion) {
  vesta::RotationMatrixToQuaternion(vesta::ColumnMajorAdapter3x3(R), quaternion);
}

// R: orthonormal, column-major unless an adapter is given. The angle is at most pi.
template <class T, int row_stride, int col_stride>
VESTA_HD void RotationMatrixToAngleAxis(const MatrixAdapter<const T, row_stride, col_stride>& R, T* angle_axis) {
  T quaternion[4];
  vesta::RotationMatrixToQuaternion(R, quaternion);
  vesta::QuaternionToAngleAxis(quaternion, angle_axis);
}
template <class T>
VESTA_HD void RotationMatrixToAngleAxis(const T* R, T* angle_axis) {
  vesta::RotationMatrixToAngleAxis(vesta::ColumnMajorAdapter3x3(R), angle_axis);
}

// The rotation matrix of q / |q|; the identity if q is 0. R: row-major unless an adapter is given.
template <class T, int row_stride, int col_stride>
VESTA_HD void QuaternionToRotation(const T q[4], const MatrixAdapter<T, row_stride, col_stride>& R) {
  T rows[9];
  vesta::RotationFromQuaternion(q, rows);
  for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = rows[i];
}
template <class T>
VESTA_HD void QuaternionToRotation(const T q[4], T R[9]) {
  vesta::RotationFromQuaternion(q, R);
}

// The rotation matrix of q / |q|, times |q|^2.
template <class T, int row_stride, int col_stride>
VESTA_HD void QuaternionToScaledRotation(const T q[4], const MatrixAdapter<T, row_stride, col_stride>& R) {
  T rows[9];
  vesta::RotationFromQuaternion(q, rows);
  const T square = q[0] * q[0] + vesta::DotProduct(q + 1, q + 1);
  for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = square * rows[i];
}
template <class T>
VESTA_HD void QuaternionToScaledRotation(const T q[4], T R[9]) {
  vesta::QuaternionToScaledRotation(q, vesta::RowMajorAdapter3x3(R));
}

// R: column-major unless an adapter is given.
template <class T, int row_stride, int col_stride>
VESTA_HD void AngleAxisToRotationMatrix(const T* angle_axis, const MatrixAdapter<T, row_stride, col_stride>& R) {
  T quaternion[4];
  vesta::AngleAxisToQuaternion(angle_axis, quaternion);
  vesta::QuaternionToRotation(quaternion, R);
}
template <class T>
VESTA_HD void AngleAxisToRotationMatrix(const T* angle_axis, T* R) {
  vesta::AngleAxisToRotationMatrix(angle_axis, vesta::ColumnMajorAdapter3x3(R));
}

// R = Rz(euler[2]) Ry(euler[1]) Rx(euler[0]), rotations about the axes z, y and x by angles in degrees. Without an
// adapter, entry (i, k) is R[i * row_stride + k].
template <class T, int row_stride, int col_stride>
VESTA_HD void EulerAnglesToRotationMatrix(const T* euler, const MatrixAdapter<T, row_stride, col_stride>& R) {
  using std::cos, std::sin;
  T c[3], s[3];
  for (int i = 0; i < 3; ++i) {
    const T angle = euler[i] * T(0.017453292519943295769);
    c[i] = cos(angle), s[i] = sin(angle);
  }
  R(0, 0) = c[2] * c[1], R(0, 1) = c[2] * s[1] * s[0] - s[2] * c[0], R(0, 2) = c[2] * s[1] * c[0] + s[2] * s[0];
  R(1, 0) = s[2] * c[1], R(1, 1) = s[2] * s[1] * s[0] + c[2] * c[0], R(1, 2) = s[2] * s[1] * c[0] - c[2] * s[0];
  R(2, 0) = -s[1], R(2, 1) = c[1] * s[0], R(2, 2) = c[1] * c[0];
}

template <class T>
VESTA_HD void EulerAnglesToRotationMatrix(const T* euler, int row_stride, T* R) {
  T rows[9];
  vesta::EulerAnglesToRotationMatrix(euler, vesta::RowMajorAdapter3x3(rows));
  for (int i = 0; i < 9; ++i) R[i / 3 * row_stride + i % 3] = rows[i];
}

// result = R(q) pt for a unit quaternion q. result may be pt.
template <class T>
VESTA_HD void UnitQuaternionRotatePoint(const T q[4], const T pt[3], T result[3]) {
  // With t = 2 v x p: R p = p + w t + v x t, where v is the vector part of q.
  T twice[3], turned[3];
  vesta::CrossProduct(q + 1, pt, twice);
  for (int i = 0; i < 3; ++i) twice[i] = twice[i] + twice[i];
  vesta::CrossProduct(q + 1, twice, turned);
  for (int i = 0; i < 3; ++i) result[i] = pt[i] + q[0] * twice[i] + turned[i];
}

// The same for any q except 0, of any length.
template <class T>
VESTA_HD void QuaternionRotatePoint(const T q[4], const T pt[3], T result[3]) {
  T unit[4];
  vesta::NormalizeQuaternion(q, unit);
  vesta::UnitQuaternionRotatePoint(unit, pt, result);
}

// result = R(angle_axis) pt. result may be pt.
template <class T>
VESTA_HD void AngleAxisRotatePoint(const T angle_axis[3], const T pt[3], T result[3]) {
  T quaternion[4];
  vesta::AngleAxisToQuaternion(angle_axis, quaternion);
  vesta::UnitQuaternionRotatePoint(quaternion, pt, result);
}

}  // namespace rotation
}  // namespace vesta
