// The per-pixel step of splatting: alpha, transmittance, and every decision on them (floor, cap, stop), in one place.
// Forward, tangent, adjoint and Gram call these with the same arguments, so their decisions agree bit for bit.
#pragma once

#include "kernels/gaussian_splatting/types.h"
#include "kernels/math/lanes.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

template <class V>
struct Alpha {
  V value;                                 // min(0.99, opacity exp(...))
  typename Lanes<V>::Mask counts;          // at or above 1/255
  typename Lanes<V>::Mask differentiable;  // below the cap: at the cap d alpha = 0
};

// p, q: whitened offset of the pixel; opacity after the sigmoid.
template <class V>
inline Alpha<V> EvaluateAlpha(const V& p, const V& half_q2, const V& opacity) {
  const V raw = opacity * FalloffExp(-Fma(V(0.5f) * p, p, half_q2));
  const V cap(static_cast<typename Lanes<V>::Scalar>(kAlphaCap));
  Alpha<V> alpha;
  alpha.value = Min(raw, cap);
  alpha.counts = raw >= V(static_cast<typename Lanes<V>::Scalar>(kAlphaFloor));
  alpha.differentiable = raw < cap;
  return alpha;
}

template <class V>
struct BlendResult {
  typename Lanes<V>::Mask counts;  // this splat is part of the pixel's colour
  V transmittance;                 // the new state
};

// One step front to back. The state is the transmittance T in front of the splat; a closed pixel keeps -T. A splat that
// would bring T below 1e-4 closes the pixel and is itself left out, as in 3DGS.
template <class V>
inline BlendResult<V> Blend(const V& transmittance, const Alpha<V>& alpha) {
  const V next = transmittance * (V(1) - alpha.value);
  const auto open = transmittance > V(0);
  const auto opaque = next < V(static_cast<typename Lanes<V>::Scalar>(kTransmittanceStop));
  const auto reached = open & alpha.counts;
  BlendResult<V> result;
  result.counts = reached & !opaque;
  result.transmittance = Select(result.counts, next, Select(reached, -transmittance, transmittance));
  return result;
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
