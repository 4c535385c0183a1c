// SPDX-License-Identifier: Apache-2.0
// An entry of the cached Jacobian of a view, written once for the loops of the host (cache_passes.h) and the kernels of
// a GPU (cache_blocks.h).
//
// An entry is a pixel and a splat that is part of it. With w = alpha T and B the colour behind the splat,
//   d colour_k = w (dc_k + (c_k - B_k) psi),   psi = d log alpha          (types.h)
// so w and the three contrasts c - B, zero where alpha is capped, are all that is kept: neither alpha nor T is needed
// again, and psi follows from the place of the pixel alone.
#pragma once

#include <type_traits>

#include "kernels/gaussian_splatting/cache/cache_kernels.h"
#include "kernels/gaussian_splatting/formulas/pixel_steps.h"
#include "kernels/math/half.h"
#include "kernels/math/scalar.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// The numbers of an entry; V: a vector of them.
template <class V>
struct Entry {
  V weight, contrast[3];

  VESTA_HD V Weight() const { return weight; }
  VESTA_HD V Contrast(int c) const { return contrast[c]; }
};

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
// By what a product with scaled entries takes component i of a tangent, or gives that of a cotangent, too large.
template <class E, class S>
VESTA_HD constexpr S EntryUnit(int i) {
  return static_cast<S>(i < kColor ? 1 / (EntryScale<E>::kWeight * EntryScale<E>::kContrast)
                                   : 1 / EntryScale<E>::kWeight);
}
template <class E, class S>
VESTA_HD inline void ToEntryUnits(SplatTangent<S>& tangent) {
  for (int i = 0; i < kSplatTangent; ++i) tangent.w[i] *= EntryUnit<E, S>(i);
}

// Makes the entry of a splat, scaled: contrast(k) takes that of colour k.
template <class E, class V>
class EntryMaker {
 public:
  VESTA_HD explicit EntryMaker(const Blend<V>& blend)
      : blend_(blend), inverse_(blend.alpha * Reciprocal(blend.weight * (V(1) - blend.alpha))) {}
  VESTA_HD V Weight() const { return V(static_cast<S>(EntryScale<E>::kWeight)) * blend_.weight; }
  // c: the splat's colour; behind: what lies behind the splat, weighted (passes.h), brought behind this one.
  VESTA_HD V Contrast(const V& c, V& behind) const {
    behind = Fnma(blend_.weight, c, behind);
    return V(static_cast<S>(EntryScale<E>::kContrast)) * MovingAlpha(blend_.alpha, Fnma(behind, inverse_, c));
  }

 private:
  using S = typename Lanes<V>::Scalar;
  const Blend<V>& blend_;
  V inverse_;  // 1 / (T (1 - alpha)); not finite where the splat is no part of the pixel, which has no entry
};

// d_color and what the entry adds to it.
template <class V>
VESTA_HD inline V AddEntry(const V& weight, const V& contrast, const V& psi, const V& dc, const V& d_color) {
  return Fma(weight, Fma(contrast, psi, dc), d_color);
}
// Adds the entry to the sums of its splat's colour (splat_sums.h), u_of(c) being u at the pixel; returns the
// derivative of u . colour by log alpha, for those of its shape.
template <class Entry, class UOf, class Sums>
VESTA_HD inline auto AddColors(const Entry& entry, const UOf& u_of, Sums& sums) {
  const auto weight = entry.Weight();
  std::remove_const_t<decltype(weight)> sum(0);
  for (int c = 0; c < 3; ++c) {
    const auto u = u_of(c);
    sums.AddColor(c, weight, u);
    sum = Fma(entry.Contrast(c), u, sum);
  }
  return weight * sum;
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
