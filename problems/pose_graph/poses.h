// SPDX-License-Identifier: Apache-2.0
// 2D and 3D poses, their steps, and the residual of a measured relative pose, with its Jacobian. R is the rotation
// matrix of a pose, p its position; angles are in radians.
#pragma once

#include <cmath>
#include <numbers>

#include "kernels/math/quaternion.h"
#include "kernels/math/scalar.h"

namespace vesta::pose_graph {

// 2D poses: (x, y, yaw). A step has a change of each number.
struct Se2 {
  static constexpr int kPose = 3;
  static constexpr int kTangent = 3;

  // Adds a multiple of 2 pi so that the angle is in [-pi, pi).
  template <class T>
  static T NormalizeAngle(const T& angle) {
    using std::floor;
    constexpr double kTurn = 2 * std::numbers::pi;
    return angle - T(kTurn) * floor((angle + T(std::numbers::pi)) / T(kTurn));
  }

  // out = x (+) delta: adds, and normalises the yaw.
  template <class T>
  static void Plus(const T* x, const T* delta, T* out) {
    out[0] = x[0] + delta[0];
    out[1] = x[1] + delta[1];
    out[2] = NormalizeAngle(x[2] + delta[2]);
  }

  // r = (R_a^T (p_b - p_a) - p_m, yaw_b - yaw_a - yaw_m in [-pi, pi)); m: measured pose of b in the frame of a.
  template <class T>
  static void Residual(const T* a, const T* b, const double* m, T* r) {
    using std::cos, std::sin;
    const T c = cos(a[2]), s = sin(a[2]);
    const T dx = b[0] - a[0], dy = b[1] - a[1];
    r[0] = c * dx + s * dy - T(m[0]);
    r[1] = c * dy - s * dx - T(m[1]);
    r[2] = NormalizeAngle(b[2] - a[2] - T(m[2]));
  }

  // Row-major 3 x 6: derivative of the residual with respect to the steps of a, then of b.
  template <class T>
  static void Jacobian(const T* a, const T* b, const double* /*m*/, T* jacobian) {
    using std::cos, std::sin;
    const T c = cos(a[2]), s = sin(a[2]), zero(0), one(1);
    const T dx = b[0] - a[0], dy = b[1] - a[1];
    const T rows[18] = {-c,   -s,   c * dy - s * dx,
                        c,    s,    zero,  //
                        s,    -c,   -(c * dx + s * dy),
                        -s,   c,    zero,  //
                        zero, zero, -one,
                        zero, zero, one};
    for (int i = 0; i < 18; ++i) jacobian[i] = rows[i];
  }
};

// 3D poses: position (x, y, z) and unit quaternion (w, x, y, z). A step has three values for the position, then three
// for the rotation.
struct Se3 {
  static constexpr int kPose = 7;
  static constexpr int kTangent = 6;

  // out = x (+) delta. Adds delta[0..3) to the position. Rotates the orientation q in the world frame by the angle 2
  // |d| about d = delta[3..6): q' = (cos |d|, d sin |d| / |d|) q. Then normalises q', because of rounding.
  template <class T>
  static void Plus(const T* x, const T* delta, T* out) {
    for (int i = 0; i < 3; ++i) out[i] = x[i] + delta[i];
    T turn[4], q[4];
    QuaternionExponential(delta + 3, turn);
    QuaternionProduct(turn, x + 3, q);
    NormalizeQuaternion(q, out + 3);
  }

  // r = (R_a^T (p_b - p_a) - p_m, 2 s vec(e)) with e = q_m (q_a^-1 q_b)^-1, where m is the measured pose of b in the
  // frame of a. The sign s makes the real part of s e positive, because e and -e are the same rotation.
  template <class T>
  static void Residual(const T* a, const T* b, const double* m, T* r) {
    T rotation[9];
    RotationFromQuaternion(a + 3, rotation);
    const T d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    for (int i = 0; i < 3; ++i) {
      r[i] = rotation[i] * d[0] + rotation[3 + i] * d[1] + rotation[6 + i] * d[2] - T(m[i]);
    }
    T g[4], error[4];
    MeasuredTimesInverse(b, m, g);
    QuaternionProduct(g, a + 3, error);
    const T twice(error[0] < T(0) ? -2 : 2);
    for (int i = 0; i < 3; ++i) r[3 + i] = twice * error[1 + i];
  }

  // Row-major 6 x 12: derivative of the residual with respect to the steps of a, then of b.
  // Let d = p_b - p_a, g = q_m q_b^-1 and q = q_a, with the real part g_w and the vector part g_v of g. Let da, db be
  // the position steps and ta, tb the orientation steps. Then
  //   dr_p = R_a^T (db - da + 2 [d]x ta),   dr_q = 2 s vec(g (0, ta - tb) q) = 2 s M (ta - tb),
  //   M = (g_w q_w + g_v.q_v) I + [q_w g_v - g_w q_v]x - (g_v q_v^T + q_v g_v^T).
  template <class T>
  static void Jacobian(const T* a, const T* b, const double* m, T* jacobian) {
    T rotation[9], g[4];
    RotationFromQuaternion(a + 3, rotation);
    MeasuredTimesInverse(b, m, g);
    const T d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const T* q = a + 3;
    const T dot = g[0] * q[0] + g[1] * q[1] + g[2] * q[2] + g[3] * q[3];
    const T real = g[0] * q[0] - g[1] * q[1] - g[2] * q[2] - g[3] * q[3];
    const T twice(real < T(0) ? -2 : 2);
    T cross[3];
    for (int i = 0; i < 3; ++i) cross[i] = q[0] * g[1 + i] - g[0] * q[1 + i];
    for (int i = 0; i < 72; ++i) jacobian[i] = T(0);
    for (int i = 0; i < 3; ++i) {
      T* position = jacobian + 12 * i;
      T* turn = jacobian + 12 * (3 + i);
      for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3, last = (k + 2) % 3;
        // Column k of the transposed rotation, and of its product with [d]x.
        position[k] = -rotation[3 * k + i];
        position[6 + k] = rotation[3 * k + i];
        position[3 + k] = T(2) * (rotation[3 * next + i] * d[last] - rotation[3 * last + i] * d[next]);
        T entry = -(g[1 + i] * q[1 + k] + q[1 + i] * g[1 + k]);
        if (i == k) entry += dot;
        if (i == next) entry += cross[last];
        if (i == last) entry -= cross[next];
        turn[3 + k] = twice * entry;
        turn[9 + k] = -twice * entry;
      }
    }
  }

 private:
  // q_m q_b^-1.
  template <class T>
  static void MeasuredTimesInverse(const T* b, const double* m, T* out) {
    const T measured[4] = {T(m[3]), T(m[4]), T(m[5]), T(m[6])};
    T inverse[4];
    QuaternionConjugate(b + 3, inverse);
    QuaternionProduct(measured, inverse, out);
  }
};

}  // namespace vesta::pose_graph
