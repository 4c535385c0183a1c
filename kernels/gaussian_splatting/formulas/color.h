// SPDX-License-Identifier: Apache-2.0
// Colour and opacity of a Gaussian in one view.
#pragma once

#include "kernels/core/hd.h"
#include "kernels/math/scalar.h"
#include "kernels/math/spherical_harmonics.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

template <class T>
VESTA_HD inline T Sigmoid(const T& logit) {
  return T(1) / (T(1) + Exp(-logit));
}

// Unit direction from the camera centre to the mean. Returns the reciprocal of the distance.
template <class S, class T>
VESTA_HD inline T ViewDirection(const S centre[3], const T mean[3], T dir[3]) {
  using std::sqrt;
  const T d0 = mean[0] - T(centre[0]), d1 = mean[1] - T(centre[1]), d2 = mean[2] - T(centre[2]);
  T inv = T(1) / sqrt(Fma(d0, d0, Fma(d1, d1, d2 * d2)));
  dir[0] = d0 * inv, dir[1] = d1 * inv, dir[2] = d2 * inv;
  return inv;
}

// color[c] = sum_k basis[k] sh(3 k + c) + 0.5, before the clamp at zero. basis: from ShBasis. sh(a) returns coefficient
// a; a function avoids a copy of the coefficients.
template <int Degree, class T, class Sh>
VESTA_HD inline void ShColor(const T* basis, const Sh& sh, T color[3]) {
  for (int c = 0; c < 3; ++c) {
    T sum(0.5f);
    for (int k = 0; k < (Degree + 1) * (Degree + 1); ++k) sum = Fma(basis[k], sh(3 * k + c), sum);
    color[c] = sum;
  }
}

// Adjoint of the colour as a function of the mean. Computes mean_bar += d(color . color_bar) / d(mean). dir,
// inv_distance: from ViewDirection. color_bar: zero for clamped channels.
template <int Degree, class T, class Sh>
VESTA_HD inline void ShColorMeanAdjoint(const T dir[3], const T& inv_distance, const Sh& sh, const T color_bar[3],
                                        T mean_bar[3]) {
  T w[(Degree + 1) * (Degree + 1)];
  for (int k = 0; k < (Degree + 1) * (Degree + 1); ++k) {
    w[k] = Fma(color_bar[0], sh(3 * k), Fma(color_bar[1], sh(3 * k + 1), color_bar[2] * sh(3 * k + 2)));
  }
  T g[3];
  ShBasisAdjoint<Degree>(dir[0], dir[1], dir[2], w, g);
  const T radial = Fma(g[0], dir[0], Fma(g[1], dir[1], g[2] * dir[2]));
  for (int i = 0; i < 3; ++i) mean_bar[i] = Fma(g[i] - radial * dir[i], inv_distance, mean_bar[i]);
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
