// SPDX-License-Identifier: Apache-2.0
// Real spherical harmonics by the recurrence of the associated Legendre functions: a reference for the polynomials in
// kernels/math/spherical_harmonics.h.
#pragma once

#include <cmath>
#include <cstdlib>
#include <numbers>

namespace vesta::test {

// The harmonics of degrees l <= degree at the unit vector d, with angles theta from z and phi around z. Entry l^2 + l +
// m of `basis` is N P_l^0(cos theta) for m = 0, else sqrt(2) N P_l^|m|(cos theta) times cos(m phi) for m > 0 and
// sin(|m| phi) for m < 0. N normalises; P includes the Condon-Shortley phase.
template <class T>
void LegendreShBasis(int degree, const T d[3], T* basis) {
  // (x + i y)^m = sin^m(theta) e^{i m phi}; legendre below is P_l^m / sin^m(theta), a polynomial in z.
  T re(1.0), im(0.0), diagonal(1.0);
  for (int m = 0; m <= degree; ++m) {
    T before(0.0), legendre = diagonal;
    for (int l = m; l <= degree; ++l) {
      if (l > m) {
        const T next = (static_cast<double>(2 * l - 1) * d[2] * legendre - static_cast<double>(l + m - 1) * before) /
                       static_cast<double>(l - m);
        before = legendre, legendre = next;
      }
      double norm2 = (2 * l + 1) / (4 * std::numbers::pi);
      for (int k = l - m + 1; k <= l + m; ++k) norm2 /= k;
      const double norm = std::sqrt(m == 0 ? norm2 : 2 * norm2);
      basis[l * l + l + m] = norm * legendre * re;
      if (m > 0) basis[l * l + l - m] = norm * legendre * im;
    }
    diagonal = diagonal * static_cast<double>(-(2 * m + 1));
    const T turned = re * d[0] - im * d[1];
    im = re * d[1] + im * d[0], re = turned;
  }
}

}  // namespace vesta::test
