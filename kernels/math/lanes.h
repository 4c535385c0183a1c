// SIMD batches as a scalar type of the templates: xsimd's batch<float> in the width of the instruction set this file is
// compiled for, and plain double as a batch of one. Included by *.simd.cpp and the headers they share only.
#pragma once

#include <xsimd/xsimd.hpp>

#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

using FloatLanes = xsimd::batch<float>;
using FloatMask = FloatLanes::batch_bool_type;

template <>
struct Elementary<FloatLanes> {
  static FloatLanes Select(const FloatMask& m, const FloatLanes& a, const FloatLanes& b) {
    return xsimd::select(m, a, b);
  }
#if defined(__AVX512F__)
  // xsimd 8.1 multiplies and adds in two instructions at this width.
  static FloatLanes Fma(const FloatLanes& a, const FloatLanes& b, const FloatLanes& c) {
    return _mm512_fmadd_ps(a, b, c);
  }
#else
  static FloatLanes Fma(const FloatLanes& a, const FloatLanes& b, const FloatLanes& c) { return xsimd::fma(a, b, c); }
#endif
  static FloatLanes Max(const FloatLanes& a, const FloatLanes& b) { return xsimd::max(a, b); }
  static FloatLanes Min(const FloatLanes& a, const FloatLanes& b) { return xsimd::min(a, b); }
};

inline bool Any(const FloatMask& m) { return xsimd::any(m); }

// exp for arguments at or below zero: 2^n e^r by a degree-5 polynomial on |r| <= ln(2) / 2 (minimax fit, 8e-8
// relative). Relative error at most 1e-6 down to -87, with and without fused multiply-adds; arguments below -87 give
// 2^-126 or so instead of less.
inline FloatLanes FalloffExp(const FloatLanes& argument) {
  const FloatLanes x = xsimd::max(argument, FloatLanes(-87.0f));
  // Adding 1.5 * 2^23 leaves the rounded integer n in the low mantissa bits; shifted up by 23 they are the exponent.
  const FloatLanes magic(12582912.0f);
  const FloatLanes biased = Fma(x, FloatLanes(1.44269504f), magic);
  // ln 2 in two parts, the first so short that its product with n is exact (Cody and Waite).
  const FloatLanes minus_n = magic - biased;
  const FloatLanes r =
      xsimd::fma(minus_n, FloatLanes(-2.12194440e-4f), xsimd::fma(minus_n, FloatLanes(0.693359375f), x));
  FloatLanes p(0.008297654272423164f);
  p = xsimd::fma(p, r, FloatLanes(0.041915381947485494f));
  p = xsimd::fma(p, r, FloatLanes(0.1666757474074756f));
  p = xsimd::fma(p, r, FloatLanes(0.4999889485174459f));
  p = xsimd::fma(p, r, FloatLanes(0.9999996919879881f));
  p = xsimd::fma(p, r, FloatLanes(1.0000000716546023f));
  const auto exponent = xsimd::bitwise_cast<xsimd::batch<int32_t>>(biased) << 23;
  return xsimd::bitwise_cast<FloatLanes>(xsimd::bitwise_cast<xsimd::batch<int32_t>>(p) + exponent);
}

// How a lane type is loaded, stored and summed. Width 1 for plain scalars.
template <class V>
struct Lanes {
  using Scalar = V;
  using Mask = bool;
  static constexpr int kWidth = 1;
  static V Load(const V* p) { return *p; }
  static void Store(V* p, const V& x) { *p = x; }
  static V Iota() { return V(0); }
  static V Sum(const V& x) { return x; }
  static void StoreMask(bool* p, bool m) { *p = m; }
  static bool LoadMask(const bool* p) { return *p; }
};

template <>
struct Lanes<FloatLanes> {
  using Scalar = float;
  using Mask = FloatMask;
  static constexpr int kWidth = static_cast<int>(FloatLanes::size);
  static FloatLanes Load(const float* p) { return FloatLanes::load_unaligned(p); }
  static void Store(float* p, const FloatLanes& x) { x.store_unaligned(p); }
  static FloatLanes Iota() {
    alignas(64) float lane[kWidth];
    for (int i = 0; i < kWidth; ++i) lane[i] = static_cast<float>(i);
    return FloatLanes::load_aligned(lane);
  }
  static float Sum(const FloatLanes& x) { return xsimd::hadd(x); }
  static void StoreMask(bool* p, const FloatMask& m) { m.store_unaligned(p); }
  static FloatMask LoadMask(const bool* p) { return FloatMask::load_unaligned(p); }
};

}  // namespace VESTA_ISA
}  // namespace vesta
