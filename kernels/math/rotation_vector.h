// SPDX-License-Identifier: Apache-2.0
// Rotation vectors: the axis of a rotation times its angle in radians, also called angle-axis.
#pragma once

#include "kernels/math/isa.h"
#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

// out = a x b. out must not be a or b.
template <class T>
VESTA_HD inline void CrossProduct(const T a[3], const T b[3], T out[3]) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out[i] = a[j] * b[k] - a[k] * b[j];
  }
}

// Computes sin(a) / a, (1 - cos a) / a^2 and (a - sin a) / a^3 from square = a^2. For a square below 0.25, uses power
// series in the square instead, because the quotients lose digits or are 0 / 0.
template <class T>
VESTA_HD void AngleCoefficients(const T& square, T coefficients[3]) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  // Term k of the three series is (-square)^k / (2 k + 1)!, (2 k + 2)!, (2 k + 3)!. The error of ten terms is less than
  // the next term, which is at most 2e-26 for a square up to 1/4.
  T series[3] = {T(0.0), T(0.0), T(0.0)};
  for (int k = 9; k >= 0; --k) {
    for (int c = 0; c < 3; ++c) {
      const double next = 1.0 / ((2 * k + c + 2) * (2 * k + c + 3));
      series[c] = T(1.0) - square * T(next) * series[c];
    }
  }
  const auto small = square < T(0.25);
  const T angle = sqrt(Select(small, T(1.0), square));
  const T half = sin(angle * T(0.5)) / angle;
  coefficients[0] = Select(small, series[0], sin(angle) / angle);
  coefficients[1] = Select(small, series[1] * T(1.0 / 2.0), half * half * T(2.0));
  coefficients[2] = Select(small, series[2] * T(1.0 / 6.0), (angle - sin(angle)) / (angle * angle * angle));
}

}  // namespace VESTA_ISA
}  // namespace vesta
