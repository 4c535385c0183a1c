// SPDX-License-Identifier: Apache-2.0
// Sums over the pixels of a splat, for its cotangent and its Gram matrix. The CPU computes the sums pixel by pixel
// (CotangentSums, GramSums). On a GPU, many threads share the work row by row (CotangentRow, GramRow). Along a row, the
// whitened coordinate q is constant, so the sums of a row contain only powers of p. These sums are multiplied by powers
// of q when the rows are added.
//
// Let u be the cotangent of the image. g is the derivative of a pixel's part of u . image with respect to log alpha,
// and w the derivative of the pixel's colour with respect to the splat's colour. With psi of pixel_steps.h:
//   cotangent = sum g (-p, -q, -p^2, -p q, -q^2, 1), then w u for each colour, then |g p|, |g q|.
//
// Gram sums: for each colour c of a pixel, omega_c is the curvature of the loss and d_c the derivative with respect to
// log alpha. w is the same for all colours. The sums are:
//   shape x shape    sum_c omega_c d_c^2, times the monomials p^a q^b of degree <= 4,
//   shape x colour   omega_c w d_c, times the monomials of degree <= 2,
//   colour x colour  omega_c w^2.
#pragma once

#include <cmath>

#include "kernels/gaussian_splatting/formulas/pixel_steps.h"
#include "kernels/gaussian_splatting/tiles/row_span.h"

namespace vesta::splat {

inline namespace VESTA_ISA {

// Sums pixel by pixel. V: a vector of pixels.
template <class V>
struct CotangentSums {
  V sum[kSplatSums];

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
  void AddPull(const V& g, const V& p, const V& q) {
    using std::abs;
    sum[kPullP] = sum[kPullP] + abs(g * p);
    sum[kPullQ] = sum[kPullQ] + abs(g * q);
  }
};

// Sums of one row: g p^a for a = 0, 1, 2, then w u for each colour, then |g p| and |g|.
inline constexpr int kCotangentRowSums = 8;
template <class S>
struct CotangentRow {
  S sum[kCotangentRowSums] = {S(0), S(0), S(0), S(0), S(0), S(0), S(0), S(0)};

  VESTA_HD void AddColor(int c, const S& w, const S& u) { sum[3 + c] = Fma(w, u, sum[3 + c]); }
  VESTA_HD void AddShape(const S& g, const S& p) {
    const S gp = g * p;
    sum[0] += g;
    sum[1] += gp;
    sum[2] = Fma(gp, p, sum[2]);
  }
  VESTA_HD void AddPull(const S& g, const S& p) {
    using std::abs;
    sum[6] += abs(g * p);
    sum[7] += abs(g);
  }
};
// Place of sum i of row y of splat k of a batch in its array of kCotangentRowSums sums. A warp adds the rows of two
// splats; in this order its threads write to different banks of shared memory.
VESTA_HD constexpr int PlaceOfRowSum(int k, int y, int i) { return (i + 4 * k + y / 4) % kCotangentRowSums; }

// Returns component i < kSplatSums of the cotangent of splat k of a batch, from the sums of its rows in a tile
// (PlaceOfRowSum). splat: from InTile (row_span.h).
template <class S>
VESTA_HD inline S CotangentFromRows(const Splat<S>& splat, const S (&rows)[kTileSize][kCotangentRowSums], int k,
                                    int i) {
  using std::abs;
  const int power_q = i < kSplatShape ? PowerQ(i) : 0, column = i < kSplatShape ? PowerP(i) : 3 + i - kColor;
  S sum(0);
  for (int y = 0; y < kTileSize; ++y) {
    const S q = RowInTile(splat, y).q;
    const S weight = i == kPullQ ? abs(q) : power_q == 0 ? S(1) : power_q == 1 ? q : q * q;
    sum = Fma(weight, rows[y][PlaceOfRowSum(k, y, column)], sum);
  }
  return i < kLambda ? -sum : sum;
}

// omega_c and d_c of one colour of a pixel, and the terms of this colour in the sums.
template <class V>
struct GramColor {
  V omega, d;

  VESTA_HD V AddToShape(const V& m) const { return Fma(omega * d, d, m); }
  VESTA_HD V Cross(const V& w) const { return omega * w * d; }
  VESTA_HD V AddToColor(const V& w, const V& color) const { return Fma(omega * w, w, color); }
};

// sums[a] += m p^a for a <= kDegree.
template <int kDegree, class V>
VESTA_HD inline void AddPowers(V m, const V& p, V* sums) {
  for (int a = 0; a <= kDegree; ++a) {
    sums[a] = sums[a] + m;
    if (a < kDegree) m = m * p;
  }
}

// Sums pixel by pixel. V: a vector of pixels of one row.
template <class V>
struct GramSums {
  V shape[kMoments4], cross[3][kMoments2], color[3];

  GramSums() {
    for (V& moment : shape) moment = V(0);
    for (int c = 0; c < 3; ++c) {
      color[c] = V(0);
      for (V& moment : cross[c]) moment = V(0);
    }
  }
  // color_of(c) returns the GramColor of colour c, one at a time to save registers.
  template <class S, class ColorOf>
  [[gnu::always_inline]] void Add(const V& w, const V& p, const S& q, const ColorOf& color_of) {
    const S q2 = q * q;
    const V q_power[5] = {V(1), V(q), V(q2), V(q2 * q), V(q2 * q2)};
    V m(0);
    for (int c = 0; c < 3; ++c) {
      const GramColor<V> of = color_of(c);
      m = of.AddToShape(m);
      color[c] = of.AddToColor(w, color[c]);
      AddMonomials<2>(of.Cross(w), p, q_power, cross[c]);
    }
    AddMonomials<4>(m, p, q_power, shape);
  }

 private:
  // sums[MonomialIndex(a, b)] += m p^a q^b for a + b <= kDegree. q_power[b] = q^b.
  template <int kDegree>
  static void AddMonomials(V m, const V& p, const V* q_power, V* sums) {
    for (int a = 0; a <= kDegree; ++a) {
      sums[MonomialIndex(a, 0)] = sums[MonomialIndex(a, 0)] + m;
      for (int b = 1; a + b <= kDegree; ++b) sums[MonomialIndex(a, b)] = Fma(m, q_power[b], sums[MonomialIndex(a, b)]);
      if (a < kDegree) m = m * p;
    }
  }
};

// Sums of a row, or a part of it: m p^a for a <= 4, with m = sum_c omega_c d_c^2; then for each colour omega_c w d_c
// p^a for a <= 2; then omega_c w^2 for each colour.
template <class S>
struct GramRow {
  static constexpr int kCross = 5, kColors = kCross + 9, kSums = kColors + 3;
  S sum[kSums];

  VESTA_HD GramRow() {
    for (S& part : sum) part = S(0);
  }
  template <class ColorOf>
  VESTA_HD void Add(const S& w, const S& p, const ColorOf& color_of) {
    S m(0);
    for (int c = 0; c < 3; ++c) {
      const GramColor<S> of = color_of(c);
      m = of.AddToShape(m);
      sum[kColors + c] = of.AddToColor(w, sum[kColors + c]);
      AddPowers<2>(of.Cross(w), p, sum + kCross + 3 * c);
    }
    AddPowers<4>(m, p, sum);
  }
};
// Powers q^b of a row for b <= 4.
inline constexpr int kRowPowers = 5;
template <class S>
VESTA_HD inline void PowersOfRow(const S& q, S power[kRowPowers]) {
  power[0] = S(1);
  for (int b = 1; b < kRowPowers; ++b) power[b] = power[b - 1] * q;
}

// Sum i of SplatGram from the sums of the rows in a tile. parts: one or more consecutive parts for each row. powers[y]:
// PowersOfRow of row y.
template <int kParts, class S>
VESTA_HD inline S GramSumFromRows(const S (&powers)[kTileSize][kRowPowers], const S (&parts)[kParts][GramRow<S>::kSums],
                                  int i) {
  constexpr int kCross = GramRow<S>::kCross, kColors = GramRow<S>::kColors, kPartsOfRow = kParts / kTileSize;
  // The monomial p^a q^b of sum i, and the index in GramRow of the sum for p^0.
  int monomial = i, base = 0;
  if (i >= kMoments4 + 3 * kMoments2) {
    monomial = 0, base = kColors + i - kMoments4 - 3 * kMoments2;
  } else if (i >= kMoments4) {
    monomial = (i - kMoments4) % kMoments2, base = kCross + 3 * ((i - kMoments4) / kMoments2);
  }
  int degree = 0;
  while (MonomialIndex(degree + 1, 0) <= monomial) ++degree;
  const int b = monomial - MonomialIndex(degree, 0), a = degree - b;
  S sum(0);
  for (int y = 0; y < kTileSize; ++y) {
    for (int part = 0; part < kPartsOfRow; ++part) {
      sum = Fma(powers[y][b], parts[y * kPartsOfRow + part][base + a], sum);
    }
  }
  return sum;
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
