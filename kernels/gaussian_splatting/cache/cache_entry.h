// SPDX-License-Identifier: Apache-2.0
// An entry of the cached Jacobian of a view, for the host (cache_passes.h) and the GPU (cache_blocks.h).
//
// An entry belongs to a pixel and a splat that contributes to it. T is the transmittance in front of the splat, w =
// alpha T the weight of its colour c in the pixel, B the colour of everything behind it. The derivative of the pixel is
//   d colour_k = w (dc_k + (c_k - B_k) psi),   psi = d log alpha          (types.h)
// An entry stores w and the three contrasts c - B. If alpha is capped, the contrasts are stored as zero, because alpha
// is then constant. psi depends only on the splat's tangent and the position of the pixel.
#pragma once

#include <type_traits>

#include "kernels/gaussian_splatting/cache/cache_kernels.h"
#include "kernels/gaussian_splatting/formulas/pixel_steps.h"
#include "kernels/math/half.h"
#include "kernels/math/scalar.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// V: a scalar, or a vector for several entries.
template <class V>
struct Entry {
  V weight, contrast[3];

  VESTA_HD V Weight() const { return weight; }
  VESTA_HD V Contrast(int c) const { return contrast[c]; }
};

// Powers of two that multiply the numbers of an entry before they are stored in format E.
template <class E>
struct EntryScale {
  static constexpr double kWeight = 1, kContrast = 1;
};
// w is in [3.9e-7, 0.99] and keeps 11 significant bits. So does a contrast c with 2.4e-7 <= |c| <= 255. Smaller
// contrasts become 0, larger ones +-255.
template <>
struct EntryScale<Half> {
  static constexpr double kWeight = 0x1p15, kContrast = 0x1p8;
};
// Factor for component i of a tangent or cotangent that cancels the entries' scaling in a product.
template <class E, class S>
VESTA_HD constexpr S InverseEntryScale(int i) {
  return static_cast<S>(i < kColor ? 1 / (EntryScale<E>::kWeight * EntryScale<E>::kContrast)
                                   : 1 / EntryScale<E>::kWeight);
}
// Applies these factors to a tangent before a product, or to a cotangent after it.
template <class E, class S>
VESTA_HD inline void DivideByEntryScale(SplatTangent<S>& tangent) {
  for (int i = 0; i < kSplatTangent; ++i) tangent.w[i] *= InverseEntryScale<E, S>(i);
}

// Computes the scaled entry of a splat.
template <class E, class V>
class EntryMaker {
 public:
  VESTA_HD explicit EntryMaker(const Blend<V>& blend)
      : blend_(blend), inverse_(blend.alpha * Reciprocal(blend.weight * (V(1) - blend.alpha))) {}
  VESTA_HD V Weight() const { return V(static_cast<S>(EntryScale<E>::kWeight)) * blend_.weight; }
  // For one colour channel c of the splat. behind: on entry, the sum of the weighted colours w c of this splat and
  // everything behind it; on return, the same sum without this splat.
  VESTA_HD V Contrast(const V& c, V& behind) const {
    behind = Fnma(blend_.weight, c, behind);
    return V(static_cast<S>(EntryScale<E>::kContrast)) * ZeroAtAlphaCap(blend_.alpha, Fnma(behind, inverse_, c));
  }

 private:
  using S = typename Lanes<V>::Scalar;
  const Blend<V>& blend_;
  V inverse_;  // 1 / (T (1 - alpha)); not finite if the splat does not contribute to the pixel (then there is no entry)
};

// Returns d_color plus the entry's contribution, for one colour channel. dc: change of the splat's colour.
template <class V>
VESTA_HD inline V AddEntry(const V& weight, const V& contrast, const V& psi, const V& dc, const V& d_color) {
  return Fma(weight, Fma(contrast, psi, dc), d_color);
}
// Adds the entry to the colour sums of its splat (splat_sums.h). u_of(c) returns channel c of u, the cotangent of the
// image, at the pixel. Returns the derivative of u . colour with respect to log alpha, for the shape's sums.
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
