// An entry of the cached Jacobian of a view, written once for the loops of the host (cache_passes.h) and the kernels of
// a GPU (cache_blocks.h).
//
// An entry is a pixel and a splat that is part of it. With w = alpha T and B the colour behind the splat,
//   d colour_k = w (dc_k + (c_k - B_k) psi),   psi = d log alpha          (types.h)
// so w and the three contrasts c - B, zero where alpha is capped, are all that is kept: neither alpha nor T is needed
// again, and psi follows from the place of the pixel alone.
#pragma once

#include "kernels/gaussian_splatting/blend.h"
#include "kernels/gaussian_splatting/cache_kernels.h"
#include "kernels/math/half.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// Powers of two that bring an entry's numbers into the range of their format.
template <class E>
struct EntryScale {
  static constexpr double kWeight = 1, kContrast = 1;
};
// w lies in [3.9e-7, 0.99]: all of it keeps 11 bits. Contrasts of at least 2.4e-7 do, and beyond 255 they saturate.
template <>
struct EntryScale<Half> {
  static constexpr double kWeight = 0x1p15, kContrast = 0x1p8;
};

// 1 / (T (1 - alpha)); not finite where the splat is no part of the pixel, which has no entry.
template <class V>
VESTA_HD inline V InverseBehind(const Blend<V>& blend) {
  return blend.alpha * Reciprocal(blend.weight * (V(1) - blend.alpha));
}
// c - B of one colour. inverse: of InverseBehind; behind: what lies behind the splat, weighted (passes.h), brought
// behind this one.
template <class V>
VESTA_HD inline V EntryContrast(const Blend<V>& blend, const V& inverse, const V& c, V& behind) {
  behind = Fnma(blend.weight, c, behind);
  return MovingAlpha(blend.alpha, Fnma(behind, inverse, c));
}
// d_color and what the entry adds to it.
template <class V>
VESTA_HD inline V AddEntry(const V& weight, const V& contrast, const V& psi, const V& dc, const V& d_color) {
  return Fma(weight, Fma(contrast, psi, dc), d_color);
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
