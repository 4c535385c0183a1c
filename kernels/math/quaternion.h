// SPDX-License-Identifier: Apache-2.0
// Quaternions (w, x, y, z) and their rotation matrices. Quaternions have any length unless stated otherwise. A name
// with _bar is a cotangent: the derivative of a scalar result with respect to that variable.
#pragma once

#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

// out = a b. out must not be a or b.
template <class T>
VESTA_HD inline void QuaternionProduct(const T a[4], const T b[4], T out[4]) {
  out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
  out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
  out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
  out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

template <class T>
VESTA_HD inline void QuaternionConjugate(const T q[4], T out[4]) {
  out[0] = q[0];
  for (int i = 1; i < 4; ++i) out[i] = -q[i];
}

// Exponential of the pure quaternion (0, d): (cos |d|, d sin |d| / |d|). It rotates about d by the angle 2 |d|.
template <class T>
VESTA_HD inline void QuaternionExponential(const T d[3], T out[4]) {
  using std::cos, std::sin, std::sqrt;
  const T square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  // Series for small angles; the first omitted term is below the rounding error.
  const auto small = square < T(1e-4);
  const T length = sqrt(Select(small, T(1), square));
  const T sinc = Select(small, T(1) - square * (T(1) - square * T(1.0 / 20)) * T(1.0 / 6), sin(length) / length);
  out[0] = Select(small, T(1) - square * (T(1) - square * T(1.0 / 12)) * T(0.5), cos(length));
  for (int i = 0; i < 3; ++i) out[1 + i] = sinc * d[i];
}

// out = q / |q|; q must not be zero.
template <class T>
VESTA_HD inline void NormalizeQuaternion(const T q[4], T out[4]) {
  using std::sqrt;
  const T scale = T(1) / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (int i = 0; i < 4; ++i) out[i] = scale * q[i];
}

// 2 / |q|^2, or 0 if |q| < 1e-12. The rotation of such a q is then the identity.
template <class T>
VESTA_HD inline T QuaternionScale(const T q[4]) {
  const T norm2 = Fma(q[0], q[0], Fma(q[1], q[1], Fma(q[2], q[2], q[3] * q[3])));
  const auto tiny = norm2 < T(1e-24f);
  return Select(tiny, T(0), T(2) / Select(tiny, T(1), norm2));
}

// R = the rotation matrix of q / |q|, row-major 3 x 3. R = I + (2 / |q|^2) P(q), where the elements of P are quadratic
// in q, so no square root is needed.
template <class T>
VESTA_HD inline void RotationFromQuaternion(const T q[4], T R[9]) {
  const T n = QuaternionScale(q);
  const T w = q[0], x = q[1], y = q[2], z = q[3];
  R[0] = T(1) - n * (y * y + z * z);
  R[1] = n * (x * y - w * z);
  R[2] = n * (x * z + w * y);
  R[3] = n * (x * y + w * z);
  R[4] = T(1) - n * (x * x + z * z);
  R[5] = n * (y * z - w * x);
  R[6] = n * (x * z - w * y);
  R[7] = n * (y * z + w * x);
  R[8] = T(1) - n * (x * x + y * y);
}

// Converts an orthonormal row-major R to the unit quaternion with w >= 0. Divides by the quaternion's largest component
// (Shepperd 1978).
template <class T>
VESTA_HD inline void QuaternionFromRotation(const T R[9], T q[4]) {
  using std::sqrt;
  const T trace = R[0] + R[4] + R[8];
  int i = 0;
  for (int k = 1; k < 3; ++k) i = R[4 * k] > R[4 * i] ? k : i;
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  if (trace > R[4 * i]) {
    const T s = T(2) * sqrt(T(1) + trace);
    q[0] = s / T(4);
    q[1] = (R[7] - R[5]) / s, q[2] = (R[2] - R[6]) / s, q[3] = (R[3] - R[1]) / s;
  } else {
    const T s = T(2) * sqrt(T(1) + R[4 * i] - R[4 * j] - R[4 * k]);
    q[0] = (R[3 * k + j] - R[3 * j + k]) / s;
    q[1 + i] = s / T(4);
    q[1 + j] = (R[3 * j + i] + R[3 * i + j]) / s;
    q[1 + k] = (R[3 * k + i] + R[3 * i + k]) / s;
  }
  for (int n = 3; n >= 0; --n) q[n] = q[0] < T(0) ? -q[n] : q[n];
}

// Adjoint of RotationFromQuaternion: computes q_bar from R_bar. R does not depend on the length of q, so q_bar is
// orthogonal to q.
template <class T>
VESTA_HD inline void RotationFromQuaternionAdjoint(const T q[4], const T R_bar[9], T q_bar[4]) {
  const T n = QuaternionScale(q);
  const T w = q[0], x = q[1], y = q[2], z = q[3];
  const T wx = R_bar[7] - R_bar[5], wy = R_bar[2] - R_bar[6], wz = R_bar[3] - R_bar[1];
  const T xy = R_bar[1] + R_bar[3], xz = R_bar[2] + R_bar[6], yz = R_bar[5] + R_bar[7];
  const T g[4] = {n * (wx * x + wy * y + wz * z), n * (wx * w + xy * y + xz * z - T(2) * x * (R_bar[4] + R_bar[8])),
                  n * (wy * w + xy * x + yz * z - T(2) * y * (R_bar[0] + R_bar[8])),
                  n * (wz * w + xz * x + yz * y - T(2) * z * (R_bar[0] + R_bar[4]))};
  const T radial = T(0.5f) * n * (q[0] * g[0] + q[1] * g[1] + q[2] * g[2] + q[3] * g[3]);
  for (int i = 0; i < 4; ++i) q_bar[i] = g[i] - radial * q[i];
}

}  // namespace VESTA_ISA
}  // namespace vesta
