// SPDX-License-Identifier: Apache-2.0
// The cotangent of a splat from its pixels. A pixel has two numbers to add: g, the derivative of its part of u . image
// by log alpha, and w, that of its colour by the splat's. With psi of pixel_steps.h
//   cotangent = sum g (-p, -q, -p^2, -p q, -q^2, 1), then w u for each colour.
// Pixel by pixel where sums stay in registers, or row by row where many threads share the work: along a row q is
// constant, so that sums of g p^a suffice, and those of the rows are weighed with powers of q at the end.
#pragma once

#include "kernels/gaussian_splatting/formulas/pixel_steps.h"
#include "kernels/gaussian_splatting/tiles/row_span.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// Pixel by pixel; V: a vector of them.
template <class V>
struct CotangentSums {
  V sum[kSplatTangent];

  CotangentSums() {
    for (V& component : sum) component = V(0);
  }
  void AddColor(int c, const V& w, const V& u) { sum[kColor + c] = Fma(w, u, sum[kColor + c]); }
  void AddShape(const V& g, const V& p, const V& q) {
    const V gp = g * p, gq = g * q;
    sum[kLambda] = sum[kLambda] + g;
    sum[kXi] = sum[kXi] - gp;
    sum[kZeta] = sum[kZeta] - gq;
    sum[kRho] = Fnma(gp, p, sum[kRho]);
    sum[kKappa] = Fnma(gq, p, sum[kKappa]);
    sum[kSigma] = Fnma(gq, q, sum[kSigma]);
  }
};

// One row: g p^a for a <= 2, then the colours.
inline constexpr int kCotangentRowSums = 6;
template <class S>
struct CotangentRow {
  S sum[kCotangentRowSums] = {S(0), S(0), S(0), S(0), S(0), S(0)};

  VESTA_HD void AddColor(int c, const S& w, const S& u) { sum[3 + c] = Fma(w, u, sum[3 + c]); }
  VESTA_HD void AddShape(const S& g, const S& p) {
    const S gp = g * p;
    sum[0] += g;
    sum[1] += gp;
    sum[2] = Fma(gp, p, sum[2]);
  }
};
// Component i from the rows of a tile. splat: of InTile.
template <class S>
VESTA_HD inline S WeighCotangentRows(const Splat<S>& splat, const S (&rows)[kTileSize][kCotangentRowSums], int i) {
  const int power_q = i < kSplatShape ? PowerQ(i) : 0, column = i < kSplatShape ? PowerP(i) : 3 + i - kColor;
  S sum(0);
  for (int y = 0; y < kTileSize; ++y) {
    const S q = RowInTile(splat, y).q;
    const S weight = power_q == 0 ? S(1) : power_q == 1 ? q : q * q;
    sum = Fma(weight, rows[y][column], sum);
  }
  return i < kLambda ? -sum : sum;
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
