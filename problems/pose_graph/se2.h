// SPDX-License-Identifier: Apache-2.0
// Poses of the plane: (x, y, yaw), and the residual of a measurement between two of them.
#pragma once

#include <cmath>
#include <numbers>

#include "kernels/math/scalar.h"

namespace vesta::pose_graph {

struct Se2 {
  static constexpr int kPose = 3;
  static constexpr int kTangent = 3;

  // The same angle within [-pi, pi).
  template <class T>
  static T NormalizeAngle(const T& angle) {
    using std::floor;
    constexpr double kTurn = 2 * std::numbers::pi;
    return angle - T(kTurn) * floor((angle + T(std::numbers::pi)) / T(kTurn));
  }

  // out = x (+) delta: position and yaw move by delta, the yaw modulo a turn.
  template <class T>
  static void Plus(const T* x, const T* delta, T* out) {
    out[0] = x[0] + delta[0];
    out[1] = x[1] + delta[1];
    out[2] = NormalizeAngle(x[2] + delta[2]);
  }

  // r = (R_a^T (p_b - p_a) - p_m, yaw_b - yaw_a - yaw_m within [-pi, pi)) for the measurement m of b as seen from a.
  template <class T>
  static void Residual(const T* a, const T* b, const double* m, T* r) {
    using std::cos, std::sin;
    const T c = cos(a[2]), s = sin(a[2]);
    const T dx = b[0] - a[0], dy = b[1] - a[1];
    r[0] = c * dx + s * dy - T(m[0]);
    r[1] = c * dy - s * dx - T(m[1]);
    r[2] = NormalizeAngle(b[2] - a[2] - T(m[2]));
  }

  // Row-major 3 x 6: derivative of the residual by the steps of a, then of b.
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

}  // namespace vesta::pose_graph
