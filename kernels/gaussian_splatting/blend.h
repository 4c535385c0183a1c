// The per-pixel step of splatting: alpha, transmittance, and every decision on them (floor, cap, stop), in one place.
// Forward, tangent, adjoint and Gram call these with the same arguments, so their decisions agree bit for bit.
#pragma once

#include "kernels/gaussian_splatting/types.h"
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
  V alpha;          // 0 where the splat is no part of the pixel
  V weight;         // alpha T, its share of the pixel's colour
  V transmittance;  // behind it
  typename Lanes<V>::Mask closes;
};

// One step front to back. transmittance: in front of the splat, 0 for closed pixels; alpha: from EvaluateAlpha. A splat
// that would bring the transmittance below 1e-4 closes the pixel and is itself left out, as in 3DGS: where closes has
// any, Close must follow.
template <class V>
VESTA_HD inline Blend<V> BlendSplat(const V& transmittance, const V& alpha) {
  using S = typename Lanes<V>::Scalar;
  const auto open = transmittance > V(0);
  Blend<V> blend;
  blend.alpha = Select(open, alpha, V(0));
  blend.weight = blend.alpha * transmittance;
  blend.transmittance = Fnma(blend.alpha, transmittance, transmittance);
  blend.closes = open & (blend.transmittance < V(static_cast<S>(kTransmittanceStop)));
  return blend;
}

// Takes the splat out of the pixels that it closes: they blend nothing and are closed from here on.
template <class V>
VESTA_HD inline void Close(Blend<V>& blend) {
  blend.alpha = Select(blend.closes, V(0), blend.alpha);
  blend.weight = Select(blend.closes, V(0), blend.weight);
  blend.transmittance = Select(blend.closes, V(0), blend.transmittance);
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
