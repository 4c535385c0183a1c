// SPDX-License-Identifier: Apache-2.0
// Elementary functions for scalars, dual numbers, ceres::Jet and SIMD batches, and the class Lanes, which loads, stores
// and sums values of these types.
//
// Templates in kernels/math and kernels/gaussian_splatting never branch on values; they use Select. The general
// Elementary is for types whose comparisons return bool, such as float, double and ceres::Jet. Dual numbers and SIMD
// batches specialise it (dual.h, lanes.h).
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "kernels/core/hd.h"
#include "kernels/math/device_scalar.h"
#include "kernels/math/isa.h"

namespace vesta {

inline namespace VESTA_ISA {

// Implements the functions below for one scalar type. It is a class template, because its specialisations may be
// included after the functions that use them. Overloads would then not be found.
template <class T>
struct Elementary {
  template <class Mask>
  VESTA_HD static T Select(const Mask& condition, const T& a, const T& b) {
    return condition ? a : b;
  }
  VESTA_HD static T Fma(const T& a, const T& b, const T& c) { return MultiplyAdd(a, b, c); }
  VESTA_HD static T Fnma(const T& a, const T& b, const T& c) { return MultiplyAdd(-a, b, c); }
  VESTA_HD static T Max(const T& a, const T& b) { return a < b ? b : a; }
  VESTA_HD static T Min(const T& a, const T& b) { return b < a ? b : a; }
  VESTA_HD static T MaskedExp2(bool mask, const T& x) { return mask ? Exp2(x) : T(0); }
  VESTA_HD static T MaskedProduct(bool mask, const T& a, const T& b) { return mask ? a * b : T(0); }
  VESTA_HD static T MaskedSquareRoot(bool mask, const T& x) {
    using std::sqrt;
    return mask ? sqrt(x) : T(0);
  }
  VESTA_HD static T Reciprocal(const T& x) { return FastReciprocal(x); }
};

// a where the condition is true, else b; lane by lane for batches.
template <class Mask, class T>
VESTA_HD inline T Select(const Mask& condition, const T& a, const T& b) {
  return Elementary<T>::Select(condition, a, b);
}
// a * b + c, fused if the hardware can.
template <class T>
VESTA_HD inline T Fma(const T& a, const T& b, const T& c) {
  return Elementary<T>::Fma(a, b, c);
}
// c - a * b, fused if the hardware can.
template <class T>
VESTA_HD inline T Fnma(const T& a, const T& b, const T& c) {
  return Elementary<T>::Fnma(a, b, c);
}
template <class T>
VESTA_HD inline T Max(const T& a, const T& b) {
  return Elementary<T>::Max(a, b);
}
template <class T>
VESTA_HD inline T Min(const T& a, const T& b) {
  return Elementary<T>::Min(a, b);
}
template <class T>
VESTA_HD inline T Clamp(const T& x, const T& lo, const T& hi) {
  return Min(Max(x, lo), hi);
}
template <class T>
VESTA_HD inline T Square(const T& x) {
  return x * x;
}

// e^x: Elementary<T>::Exp if that exists, else exp of the type's own namespace or of std.
template <class T>
VESTA_HD inline T Exp(const T& x) {
  if constexpr (requires { Elementary<T>::Exp(x); }) {
    return Elementary<T>::Exp(x);
  } else {
    using std::exp;
    return exp(x);
  }
}
// 2^x where mask is set, else 0.
template <class Mask, class T>
VESTA_HD inline T MaskedExp2(const Mask& mask, const T& x) {
  return Elementary<T>::MaskedExp2(mask, x);
}
// a * b where mask is set, else 0.
template <class Mask, class T>
VESTA_HD inline T MaskedProduct(const Mask& mask, const T& a, const T& b) {
  return Elementary<T>::MaskedProduct(mask, a, b);
}
// sqrt(x) where mask is set, else 0.
template <class Mask, class T>
VESTA_HD inline T MaskedSquareRoot(const Mask& mask, const T& x) {
  return Elementary<T>::MaskedSquareRoot(mask, x);
}
// 1 / x for x in [2^-100, 2^100], perhaps less accurate than a division (lanes.h, device_scalar.h).
template <class T>
VESTA_HD inline T Reciprocal(const T& x) {
  return Elementary<T>::Reciprocal(x);
}

// Loads, stores and sums values of type V. A plain scalar is a vector of one lane.
template <class V>
struct Lanes {
  using Scalar = V;
  using Mask = bool;
  static constexpr int kWidth = 1;
  VESTA_HD static V Load(const V* p) { return *p; }
  VESTA_HD static void Store(V* p, const V& x) { *p = x; }
  // The lane numbers 0, 1, 2, ...
  VESTA_HD static V Iota() { return V(0); }
  // out[i] = the sum of the lanes of v[i].
  template <int kCount>
  VESTA_HD static void SumEach(const V* v, V* out) {
    for (int i = 0; i < kCount; ++i) out[i] = v[i];
  }
  VESTA_HD static bool Any(bool m) { return m; }
  // Returns a mask as an integer: bit i is lane i.
  VESTA_HD static std::uint32_t Bits(bool m) { return m ? 1 : 0; }
  VESTA_HD static void StoreMask(bool* p, bool m) { *p = m; }
  VESTA_HD static bool LoadMask(const bool* p) { return *p; }
};

}  // namespace VESTA_ISA
}  // namespace vesta
