// SPDX-License-Identifier: Apache-2.0
// The per-pixel step of splatting: alpha, transmittance, and every decision on them (floor, cap, stop), in one place.
// Forward, tangent, adjoint and Gram call these with the same arguments, so their decisions agree bit for bit.
#pragma once

#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/math/lane_traits.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// alpha = min(0.99, 2^exponent) where that is at least 1/255, else 0: what an open pixel blends.
template <class V>
VESTA_HD inline V EvaluateAlpha(const V& exponent) {
  using S = typename Lanes<V>::Scalar;
  return Min(MaskedExp2(exponent >= V(static_cast<S>(kLog2AlphaFloor)), exponent), V(static_cast<S>(kAlphaCap)));
}

// What d alpha is multiplied by to give d log alpha's share: alpha, or 0 at the cap, where alpha stands still.
template <class V>
VESTA_HD inline V MovingAlpha(const V& alpha, const V& value) {
  return Select(alpha < V(static_cast<typename Lanes<V>::Scalar>(kAlphaCap)), value, V(0));
}

// What a splat does to the pixels of a vector.
template <class V>
struct Blend {
  typename Lanes<V>::Mask open;  // those that it does not close, nor did a splat in front of it
  V alpha;                       // 0 where the splat is no part of the pixel
  V weight;                      // alpha T, its share of the pixel's colour
  V transmittance;               // behind it where the pixel is open, below 1e-4 where it is not
};

// One step front to back. transmittance: in front of the splat, or anything from 0 to 1e-4 for closed pixels; alpha:
// from EvaluateAlpha. A splat that would bring the transmittance below 1e-4 closes the pixel and is itself left out, as
// in 3DGS. The transmittance never grows, so that comparing it at each splat tells of all splats before.
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

}  // namespace VESTA_ISA
}  // namespace vesta::splat
