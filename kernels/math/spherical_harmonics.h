// SPDX-License-Identifier: Apache-2.0
// Real spherical harmonics, bands 0 to 3, as polynomials of a unit direction (Sloan, "Efficient Spherical Harmonic
// Evaluation", JCGT 2013), with the signs of the 3DGS file format.
#pragma once

#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

inline constexpr int kMaxShCoefficients = 16;
VESTA_HD constexpr int ShCoefficients(int degree) { return (degree + 1) * (degree + 1); }

namespace sh {
inline constexpr double k0 = 0.28209479177387814;   // 1 / (2 sqrt(pi))
inline constexpr double k1 = 0.48860251190291992;   // sqrt(3 / (4 pi))
inline constexpr double k2a = 1.0925484305920790;   // sqrt(15 / (4 pi))
inline constexpr double k2b = 0.31539156525252001;  // sqrt(5 / (16 pi))
inline constexpr double k2c = 0.54627421529603953;  // sqrt(15 / (16 pi))
inline constexpr double k3a = 0.59004358992664351;  // sqrt(35 / (32 pi))
inline constexpr double k3b = 2.8906114426405540;   // sqrt(105 / (4 pi))
inline constexpr double k3c = 0.45704579946446577;  // sqrt(21 / (32 pi))
inline constexpr double k3d = 0.37317633259011540;  // sqrt(7 / (16 pi))
inline constexpr double k3e = 1.4453057213202770;   // sqrt(105 / (16 pi))
}  // namespace sh

// Computes basis[0 .. (Degree+1)^2) at the unit direction (x, y, z).
template <int Degree, class T>
VESTA_HD inline void ShBasis(const T& x, const T& y, const T& z, T* basis) {
  basis[0] = T(sh::k0);
  if constexpr (Degree >= 1) {
    basis[1] = T(-sh::k1) * y;
    basis[2] = T(sh::k1) * z;
    basis[3] = T(-sh::k1) * x;
  }
  if constexpr (Degree >= 2) {
    const T xx = x * x, yy = y * y, zz = z * z;
    basis[4] = T(sh::k2a) * (x * y);
    basis[5] = T(-sh::k2a) * (y * z);
    basis[6] = T(sh::k2b) * (T(2) * zz - xx - yy);
    basis[7] = T(-sh::k2a) * (x * z);
    basis[8] = T(sh::k2c) * (xx - yy);
    if constexpr (Degree >= 3) {
      basis[9] = T(-sh::k3a) * y * (T(3) * xx - yy);
      basis[10] = T(sh::k3b) * (x * y) * z;
      basis[11] = T(-sh::k3c) * y * (T(4) * zz - xx - yy);
      basis[12] = T(sh::k3d) * z * (T(2) * zz - T(3) * xx - T(3) * yy);
      basis[13] = T(-sh::k3c) * x * (T(4) * zz - xx - yy);
      basis[14] = T(sh::k3e) * z * (xx - yy);
      basis[15] = T(-sh::k3a) * x * (xx - T(3) * yy);
    }
  }
}

// g = sum_k w[k] * d basis[k] / d(x, y, z), without the constraint that the direction has length 1.
template <int Degree, class T>
VESTA_HD inline void ShBasisAdjoint(const T& x, const T& y, const T& z, const T* w, T g[3]) {
  g[0] = g[1] = g[2] = T(0);
  if constexpr (Degree >= 1) {
    g[0] = T(-sh::k1) * w[3];
    g[1] = T(-sh::k1) * w[1];
    g[2] = T(sh::k1) * w[2];
  }
  if constexpr (Degree >= 2) {
    const T w4 = T(sh::k2a) * w[4], w5 = T(-sh::k2a) * w[5], w6 = T(2 * sh::k2b) * w[6], w7 = T(-sh::k2a) * w[7],
            w8 = T(2 * sh::k2c) * w[8];
    g[0] += w4 * y - w6 * x + w7 * z + w8 * x;
    g[1] += w4 * x + w5 * z - w6 * y - w8 * y;
    g[2] += w5 * y + T(2) * w6 * z + w7 * x;
  }
  if constexpr (Degree >= 3) {
    const T xx = x * x, yy = y * y, zz = z * z, xy = x * y;
    const T w9 = T(-sh::k3a) * w[9], w10 = T(sh::k3b) * w[10], w11 = T(-sh::k3c) * w[11], w12 = T(sh::k3d) * w[12],
            w13 = T(-sh::k3c) * w[13], w14 = T(sh::k3e) * w[14], w15 = T(-sh::k3a) * w[15];
    g[0] += T(6) * w9 * xy + w10 * (y * z) - T(2) * w11 * xy - T(6) * w12 * (x * z) +
            w13 * (T(4) * zz - T(3) * xx - yy) + T(2) * w14 * (x * z) + T(3) * w15 * (xx - yy);
    g[1] += T(3) * w9 * (xx - yy) + w10 * (x * z) + w11 * (T(4) * zz - xx - T(3) * yy) - T(6) * w12 * (y * z) -
            T(2) * w13 * xy - T(2) * w14 * (y * z) - T(6) * w15 * xy;
    g[2] += w10 * xy + T(8) * w11 * (y * z) + w12 * (T(6) * zz - T(3) * xx - T(3) * yy) + T(8) * w13 * (x * z) +
            w14 * (xx - yy);
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta
