// The four raster passes over one tile: image, tangent, adjoint and Gram sums.
//
// With w = alpha T and S = what lies behind a splat, already weighted (the final colour minus what has been accumulated
// up to and including the splat),
//   d colour / d c = w,   d colour / d log alpha = w c - S alpha / (1 - alpha),   d log alpha = psi,
//   psi = lambda - p (xi + kappa q + rho p) - q (zeta + sigma q)        (types.h)
// so adjoint and Gram go front to back too and no per-pixel state is stored between passes.
#pragma once

#include "kernels/gaussian_splatting/traverse.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

template <class V, class S>
struct ForwardPass {
  using L = Lanes<V>;
  alignas(64) S color[3][kTilePixels] = {};
  V c[3];

  void BeginSplat(std::uint32_t, const Splat<S>& splat) {
    for (int k = 0; k < 3; ++k) c[k] = V(splat.color[k]);
  }
  void BeginRow(S) {}
  void Pixels(int offset, const V&, const V&, const V& weight) {
    for (int k = 0; k < 3; ++k) L::Store(color[k] + offset, Fma(weight, c[k], L::Load(color[k] + offset)));
  }
  void EndRow() {}
  void EndSplat(std::int64_t) {}
  void Skip(std::int64_t) {}
};

template <class V, class S>
struct TangentPass {
  using L = Lanes<V>;
  const SplatTangent<S>* tangents;
  alignas(64) S d_color[3][kTilePixels] = {};
  alignas(64) S minus_dT[kTilePixels] = {};  // of the transmittance
  V c[3], dc[3], rho, row_linear, row_constant;
  const S* w = nullptr;

  void BeginSplat(std::uint32_t rank, const Splat<S>& splat) {
    w = tangents[rank].w;
    for (int k = 0; k < 3; ++k) c[k] = V(splat.color[k]), dc[k] = V(w[kColor + k]);
    rho = V(w[kRho]);
  }
  void BeginRow(S q) {
    row_linear = V(w[kXi] + w[kKappa] * q);
    row_constant = V(w[kLambda] - q * (w[kZeta] + w[kSigma] * q));
  }
  void Pixels(int offset, const V& p, const V& alpha, const V& weight) {
    const V psi = Fnma(p, Fma(rho, p, row_linear), row_constant);
    const V d_alpha_T = MovingAlpha(alpha, weight) * psi;
    const V before = L::Load(minus_dT + offset);
    const V d_weight = Fnma(alpha, before, d_alpha_T);
    for (int k = 0; k < 3; ++k) {
      L::Store(d_color[k] + offset, Fma(weight, dc[k], Fma(d_weight, c[k], L::Load(d_color[k] + offset))));
    }
    // Not before + d_weight, which behind opaque splats is a small difference of large numbers.
    L::Store(minus_dT + offset, Fma(before, V(1) - alpha, d_alpha_T));
  }
  void EndRow() {}
  void EndSplat(std::int64_t) {}
  void Skip(std::int64_t) {}
};

template <class V, class S>
struct AdjointPass {
  using L = Lanes<V>;
  SplatTangent<S>* sums;              // [pairs], relative to the whole list
  alignas(64) S u[3][kTilePixels];    // cotangent of the image
  alignas(64) S behind[kTilePixels];  // u . S
  V c[3], total[kSplatTangent], vq;

  void BeginSplat(std::uint32_t, const Splat<S>& splat) {
    for (int k = 0; k < 3; ++k) c[k] = V(splat.color[k]);
    for (V& t : total) t = V(0);
  }
  void BeginRow(S q) { vq = V(q); }
  void Pixels(int offset, const V& p, const V& alpha, const V& weight) {
    const V u0 = L::Load(u[0] + offset), u1 = L::Load(u[1] + offset), u2 = L::Load(u[2] + offset);
    const V share = weight * Fma(c[0], u0, Fma(c[1], u1, c[2] * u2));
    const V rest = L::Load(behind + offset) - share;
    L::Store(behind + offset, rest);
    total[kColor] = Fma(weight, u0, total[kColor]);
    total[kColor + 1] = Fma(weight, u1, total[kColor + 1]);
    total[kColor + 2] = Fma(weight, u2, total[kColor + 2]);
    // By log alpha, as long as that is free to move.
    const V g = MovingAlpha(alpha, Fnma(rest, alpha * Reciprocal(V(1) - alpha), share));
    const V gp = g * p, gq = g * vq;
    total[kLambda] = total[kLambda] + g;
    total[kXi] = total[kXi] + gp;
    total[kZeta] = total[kZeta] + gq;
    total[kRho] = Fma(gp, p, total[kRho]);
    total[kKappa] = Fma(gq, p, total[kKappa]);
    total[kSigma] = Fma(gq, vq, total[kSigma]);
  }
  void EndRow() {}
  void EndSplat(std::int64_t pair) {
    S* w = sums[pair].w;
    L::template SumEach<kSplatTangent>(total, w);
    for (int k = 0; k < kLambda; ++k) w[k] = -w[k];
  }
  void Skip(std::int64_t pair) { sums[pair] = {}; }
};

template <class V, class S>
struct GramPass {
  using L = Lanes<V>;
  SplatGram<S>* sums;
  alignas(64) S weight[3][kTilePixels];  // omega, the curvature of the loss by each colour
  alignas(64) S behind[3][kTilePixels];
  V c[3], shape[kMoments4], cross[3][kMoments2], color[3];
  V row_shape[5], row_cross[3][3];
  S q = S(0);

  void BeginSplat(std::uint32_t, const Splat<S>& splat) {
    for (int k = 0; k < 3; ++k) c[k] = V(splat.color[k]);
    for (V& m : shape) m = V(0);
    for (int k = 0; k < 3; ++k) {
      color[k] = V(0);
      for (V& m : cross[k]) m = V(0);
    }
  }
  void BeginRow(S row_q) {
    q = row_q;
    for (V& m : row_shape) m = V(0);
    for (auto& channel : row_cross) {
      for (V& m : channel) m = V(0);
    }
  }
  void Pixels(int offset, const V& p, const V& alpha, const V& weight_here) {
    const V odds = alpha * Reciprocal(V(1) - alpha);
    V m(0);
    for (int k = 0; k < 3; ++k) {
      const V share = weight_here * c[k];
      const V rest = L::Load(behind[k] + offset) - share;
      L::Store(behind[k] + offset, rest);
      const V omega = L::Load(weight[k] + offset);
      const V d = MovingAlpha(alpha, Fnma(rest, odds, share));  // d colour / d log alpha
      const V omega_d = omega * d, omega_w = omega * weight_here;
      m = Fma(omega_d, d, m);
      color[k] = Fma(omega_w, weight_here, color[k]);
      const V x = omega_w * d, xp = x * p;
      row_cross[k][0] = row_cross[k][0] + x;
      row_cross[k][1] = row_cross[k][1] + xp;
      row_cross[k][2] = Fma(xp, p, row_cross[k][2]);
    }
    row_shape[0] = row_shape[0] + m;
    for (int a = 1; a < 5; ++a) {
      m = m * p;
      row_shape[a] = row_shape[a] + m;
    }
  }
  void EndRow() {
    V power(1);  // q^b
    for (int b = 0; b < 5; ++b, power = power * V(q)) {
      for (int a = 0; a + b < 5; ++a) shape[MonomialIndex(a, b)] = Fma(power, row_shape[a], shape[MonomialIndex(a, b)]);
      if (b >= 3) continue;
      for (int k = 0; k < 3; ++k) {
        for (int a = 0; a + b < 3; ++a)
          cross[k][MonomialIndex(a, b)] = Fma(power, row_cross[k][a], cross[k][MonomialIndex(a, b)]);
      }
    }
  }
  void EndSplat(std::int64_t pair) {
    S* out = sums[pair].m;
    L::template SumEach<kMoments4>(shape, out);
    L::template SumEach<3 * kMoments2>(cross[0], out + kMoments4);
    L::template SumEach<3>(color, out + kMoments4 + 3 * kMoments2);
  }
  void Skip(std::int64_t pair) { sums[pair] = {}; }
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
