// SPDX-License-Identifier: Apache-2.0
// The computations of all raster passes for one splat and one pixel, shared by the CPU (passes.h) and the GPU. T is the
// transmittance in front of the splat, w = alpha T its weight, c its colour, and S the sum of the weighted colours w c
// of everything behind it, including the background:
//   d colour / d c = w,   d colour / d log alpha = w c - S alpha / (1 - alpha),   d log alpha = psi,
//   psi = lambda - p (xi + kappa q + rho p) - q (zeta + sigma q)        (types.h, docs/mathematics.md section 3)
// Forward, tangent, adjoint and Gram passes call these functions with the same arguments. All passes therefore agree
// where alpha is below its floor or at its cap, and where a pixel is closed. A pixel is open until a splat would reduce
// T to less than 1e-4; this splat closes the pixel.
#pragma once

#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/math/scalar.h"

namespace vesta::splat {

inline namespace VESTA_ISA {

// Alpha of a splat at an open pixel: min(0.99, 2^exponent) if that is at least 1/255, else 0.
template <class V>
VESTA_HD inline V EvaluateAlpha(const V& exponent) {
  using S = typename Lanes<V>::Scalar;
  return Min(MaskedExp2(exponent >= V(static_cast<S>(kLog2AlphaFloor)), exponent), V(static_cast<S>(kAlphaCap)));
}

// Returns `value`, a derivative with respect to log alpha, or 0 if alpha is at its cap and thus constant.
template <class V>
VESTA_HD inline V ZeroAtAlphaCap(const V& alpha, const V& value) {
  return Select(alpha < V(static_cast<typename Lanes<V>::Scalar>(kAlphaCap)), value, V(0));
}

// A splat blended into a vector of pixels.
template <class V>
struct Blend {
  typename Lanes<V>::Mask open;  // pixels not yet closed, by this splat or one in front
  V alpha;                       // 0 if the splat does not contribute to the pixel
  V weight;                      // alpha T, the weight of the splat's colour in the pixel
  V transmittance;               // behind the splat; below 1e-4 for closed pixels
};

// Blends one splat, front to back. transmittance: in front of the splat; any value from 0 to 1e-4 for closed pixels.
// alpha: from EvaluateAlpha. A splat that would reduce the transmittance to less than 1e-4 closes the pixel, and is not
// blended, as in 3DGS. The transmittance never increases, so a single comparison also finds pixels closed earlier.
template <class V>
VESTA_HD inline Blend<V> BlendSplat(const V& transmittance, const V& alpha) {
  using S = typename Lanes<V>::Scalar;
  Blend<V> blend;
  blend.transmittance = Fnma(alpha, transmittance, transmittance);
  blend.open = blend.transmittance >= V(static_cast<S>(kTransmittanceStop));
  blend.alpha = Select(blend.open, alpha, V(0));
  blend.weight = MaskedProduct(blend.open, alpha, transmittance);
  return blend;
}

// For pixel x of a row of a tile (RowSpan in row_span.h): the whitened coordinate p, the log2 of alpha without floor
// and cap, and alpha.
template <class V>
VESTA_HD inline V OffsetAt(const V& x, const V& r, const V& p0) {
  return Fma(x, r, p0);
}
template <class V>
VESTA_HD inline V ExponentAt(const V& p, const V& peak) {
  return Fnma(p, p, peak);
}
template <class V>
VESTA_HD inline V AlphaAt(const V& p, const V& peak) {
  return EvaluateAlpha(ExponentAt(p, peak));
}

// psi along a row, where q is constant, as a polynomial in p: constant - p (linear + rho p).
template <class V>
VESTA_HD inline V PsiLinear(const V& xi, const V& kappa, const V& q) {
  return Fma(kappa, q, xi);
}
template <class V>
VESTA_HD inline V PsiConstant(const V& zeta, const V& sigma, const V& lambda, const V& q) {
  return Fnma(q, Fma(sigma, q, zeta), lambda);
}
template <class V>
VESTA_HD inline V Psi(const V& linear, const V& constant, const V& rho, const V& p) {
  return Fnma(p, Fma(rho, p, linear), constant);
}
template <class S>
VESTA_HD inline S Psi(const SplatTangent<S>& tangent, const S& p, const S& q) {
  const S* w = tangent.w;
  return Psi(PsiLinear(w[kXi], w[kKappa], q), PsiConstant(w[kZeta], w[kSigma], w[kLambda], q), w[kRho], p);
}

// Returns the change of w for a change psi of log alpha. minus_dT: minus the change of the transmittance, in front of
// the splat on entry, behind it on return.
template <class V>
VESTA_HD inline V TangentWeight(const Blend<V>& blend, const V& psi, V& minus_dT) {
  const V d_alpha_T = ZeroAtAlphaCap(blend.alpha, blend.weight) * psi;
  const V d_weight = Fnma(blend.alpha, minus_dT, d_alpha_T);
  // Equal to minus_dT + d_weight. But behind opaque splats that sum is a small difference of large numbers.
  minus_dT = Fma(minus_dT, V(1) - blend.alpha, d_alpha_T);
  return d_weight;
}
// Returns d_color plus the change of w c. dc: change of c.
template <class V>
VESTA_HD inline V TangentColor(const Blend<V>& blend, const V& d_weight, const V& c, const V& dc, const V& d_color) {
  return Fma(blend.weight, dc, Fma(d_weight, c, d_color));
}

// Contribution of a splat of colour c to u . colour of the pixel. u: cotangent of the image.
template <class V>
VESTA_HD inline V ContributionOf(const Blend<V>& blend, const V c[3], const V u[3]) {
  return blend.weight * Fma(c[0], u[0], Fma(c[1], u[1], c[2] * u[2]));
}
// alpha / (1 - alpha).
template <class V>
VESTA_HD inline V AlphaOdds(const V& alpha) {
  return alpha * Reciprocal(V(1) - alpha);
}
// A pixel's colour, or u . colour, is a sum of contributions of splats. Returns the sum's derivative with respect to
// log alpha of this splat; 0 at the cap. odds: AlphaOdds. share: this splat's contribution. behind: on entry, the
// contributions of this splat and everything behind it; on return, without this splat.
template <class V>
VESTA_HD inline V ByLogAlpha(const Blend<V>& blend, const V& odds, const V& share, V& behind) {
  behind = behind - share;
  return ZeroAtAlphaCap(blend.alpha, Fnma(behind, odds, share));
}

// The derivative of psi with respect to component i is -p^PowerP(i) q^PowerQ(i) for i = kXi, ..., kSigma, and 1 for
// kLambda.
VESTA_HD constexpr int PowerP(int i) { return i == kRho ? 2 : i == kXi || i == kKappa ? 1 : 0; }
VESTA_HD constexpr int PowerQ(int i) { return i == kSigma ? 2 : i == kZeta || i == kKappa ? 1 : 0; }

}  // namespace VESTA_ISA
}  // namespace vesta::splat
