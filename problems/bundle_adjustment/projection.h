// SPDX-License-Identifier: Apache-2.0
// The camera model of "Bundle adjustment in the large" (Agarwal, Snavely, Seitz, Szeliski, ECCV 2010), and its
// derivatives.
//
// A camera has nine parameters: angle-axis vector w (radians), translation t, focal length f (pixels), radial
// distortion k1, k2. It projects a world point X to
//   P = R(w) X + t,  p = -(P_x, P_y) / P_z,  prediction = f (1 + k1 |p|^2 + k2 |p|^4) p   [pixels],
// where R(w) is the rotation matrix. The camera looks along its negative z axis. Image coordinates start at the image
// centre.
//
// T is the scalar type: double, ceres::Jet, or Quad (quad.h), which has four observations in SIMD lanes.
#pragma once

#include <cmath>

#include "kernels/math/rotation_vector.h"

namespace vesta::bundle {

inline constexpr int kCameraSize = 9;
inline constexpr int kPointSize = 3;
// Columns of an observation's Jacobian: three for the point, then nine for the camera.
inline constexpr int kRowSize = kPointSize + kCameraSize;

// A camera prepared for the projection of many points. Matrices are row-major 3 x 3.
template <class T>
struct Camera {
  T rotation[9];
  // Left Jacobian J of the rotation group: R(w + d) = R(J d) R(w) to first order in d.
  T left_jacobian[9];
  T translation[3];
  T focal, k1, k2;
};

// Intermediate values of a projection that its derivative reuses.
template <class T>
struct Projection {
  T rotated[3];    // R X
  T inverse_z;     // 1 / P_z
  T p[2];          // -(P_x, P_y) / P_z
  T square;        // |p|^2
  T distortion;    // 1 + k1 |p|^2 + k2 |p|^4
  T predicted[2];  // pixels
};

inline namespace VESTA_ISA {

// Prepares a camera. A, B, C are from AngleCoefficients; [w] is the cross-product matrix:
//   R = I + A [w] + B [w]^2 (Rodrigues),  left Jacobian = I + B [w] + C [w]^2,  [w]^2 = w w' - |w|^2 I.
template <class T>
VESTA_HD Camera<T> MakeCamera(const T* parameters) {
  const T* w = parameters;
  const T square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
  T c[3];
  AngleCoefficients(square, c);
  Camera<T> camera;
  const auto fill = [&](const T& first, const T& second, T* matrix) {
    const T cross[9] = {T(0.0), -w[2], w[1], w[2], T(0.0), -w[0], -w[1], w[0], T(0.0)};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        T value = first * cross[3 * i + j] + second * w[i] * w[j];
        if (i == j) value = value + T(1.0) - second * square;
        matrix[3 * i + j] = value;
      }
    }
  };
  fill(c[0], c[1], camera.rotation);
  fill(c[1], c[2], camera.left_jacobian);
  for (int i = 0; i < 3; ++i) camera.translation[i] = parameters[3 + i];
  camera.focal = parameters[6], camera.k1 = parameters[7], camera.k2 = parameters[8];
  return camera;
}

template <class T>
VESTA_HD Projection<T> Project(const Camera<T>& camera, const T X[3]) {
  Projection<T> out;
  T P[3];
  for (int i = 0; i < 3; ++i) {
    const T* row = camera.rotation + 3 * i;
    out.rotated[i] = row[0] * X[0] + row[1] * X[1] + row[2] * X[2];
    P[i] = out.rotated[i] + camera.translation[i];
  }
  out.inverse_z = T(1.0) / P[2];
  for (int i = 0; i < 2; ++i) out.p[i] = T(0.0) - P[i] * out.inverse_z;
  out.square = out.p[0] * out.p[0] + out.p[1] * out.p[1];
  out.distortion = T(1.0) + out.square * (camera.k1 + camera.k2 * out.square);
  for (int i = 0; i < 2; ++i) out.predicted[i] = camera.focal * out.distortion * out.p[i];
  return out;
}

// jacobian[12 * i + c]: derivative of predicted[i] with respect to entry c of (X, w, t, f, k1, k2).
template <class T>
VESTA_HD void ProjectionJacobian(const Camera<T>& camera, const Projection<T>& at, T* jacobian) {
  // predicted = f d(p) p, so its derivative by p is f (d I + (2 k1 + 4 k2 |p|^2) p p').
  const T slope = T(2.0) * camera.k1 + T(4.0) * camera.k2 * at.square;
  const T mixed = camera.focal * slope * at.p[0] * at.p[1];
  const T by_p[2][2] = {{camera.focal * (at.distortion + slope * at.p[0] * at.p[0]), mixed},
                        {mixed, camera.focal * (at.distortion + slope * at.p[1] * at.p[1])}};
  const T minus_inverse_z = T(0.0) - at.inverse_z;
  for (int i = 0; i < 2; ++i) {
    T* row = jacobian + kRowSize * i;
    // By P: p's derivative is -1/P_z (1 0 p_x; 0 1 p_y).
    const T h[3] = {minus_inverse_z * by_p[i][0], minus_inverse_z * by_p[i][1],
                    minus_inverse_z * (by_p[i][0] * at.p[0] + by_p[i][1] * at.p[1])};
    // By w: d(R X) = (J dw) x (R X), and h . (a x q) = a . (q x h).
    const T* q = at.rotated;
    const T turn[3] = {q[1] * h[2] - q[2] * h[1], q[2] * h[0] - q[0] * h[2], q[0] * h[1] - q[1] * h[0]};
    const auto times = [](const T* v, const T* matrix, T* out) {
      for (int c = 0; c < 3; ++c) out[c] = v[0] * matrix[c] + v[1] * matrix[3 + c] + v[2] * matrix[6 + c];
    };
    times(h, camera.rotation, row);
    times(turn, camera.left_jacobian, row + 3);
    for (int c = 0; c < 3; ++c) row[6 + c] = h[c];
    row[9] = at.distortion * at.p[i];
    row[10] = camera.focal * at.square * at.p[i];
    row[11] = row[10] * at.square;
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta::bundle
