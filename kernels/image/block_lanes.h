// SPDX-License-Identifier: Apache-2.0
// Several: a few SIMD vectors of pixels as one scalar of the formulas. image_kernels.simd.cpp includes this header
// before the formulas, which call its functions.
#pragma once

#include <type_traits>
#include <utility>

#include "kernels/math/lanes.h"

namespace vesta {
inline namespace VESTA_ISA {

// Calls f(0), ..., f(kCount - 1) with compile-time constants.
template <int kCount, class F>
inline void Unrolled(const F& f) {
  [&]<int... k>(std::integer_sequence<int, k...>) { (f(std::integral_constant<int, k>{}), ...); }
  (std::make_integer_sequence<int, kCount>{});
}

using DoubleLanes = xsimd::batch<double>;

template <>
struct Elementary<DoubleLanes> {
  using Mask = DoubleLanes::batch_bool_type;
  static DoubleLanes Select(const Mask& m, const DoubleLanes& a, const DoubleLanes& b) {
    return xsimd::select(m, a, b);
  }
  static DoubleLanes Fma(const DoubleLanes& a, const DoubleLanes& b, const DoubleLanes& c) {
    return xsimd::fma(a, b, c);
  }
  static DoubleLanes Fnma(const DoubleLanes& a, const DoubleLanes& b, const DoubleLanes& c) {
    return xsimd::fnma(a, b, c);
  }
  static DoubleLanes Max(const DoubleLanes& a, const DoubleLanes& b) { return xsimd::max(a, b); }
  static DoubleLanes Min(const DoubleLanes& a, const DoubleLanes& b) { return xsimd::min(a, b); }
};

inline DoubleLanes Reciprocal(const DoubleLanes& x) { return DoubleLanes(1) / x; }

// kCount vectors as one scalar. The formula of an SSIM window is a chain of about thirty dependent operations. With
// several vectors, the processor computes independent chains at the same time instead of waiting.
template <class V, int kCount>
struct Several {
  V v[kCount];

  Several() = default;
  explicit Several(typename V::value_type x) {
    for (V& vector : v) vector = V(x);
  }
  // Applies f to each vector of the arguments.
  template <class F, class... Args>
  static Several Each(const F& f, const Args&... args) {
    Several result;
    Unrolled<kCount>([&](auto i) { result.v[i] = f(args.v[i]...); });
    return result;
  }
  friend Several operator+(const Several& a, const Several& b) {
    return Each([](const V& x, const V& y) { return x + y; }, a, b);
  }
  friend Several operator-(const Several& a, const Several& b) {
    return Each([](const V& x, const V& y) { return x - y; }, a, b);
  }
  friend Several operator*(const Several& a, const Several& b) {
    return Each([](const V& x, const V& y) { return x * y; }, a, b);
  }
  friend Several operator-(const Several& a) {
    return Each([](const V& x) { return -x; }, a);
  }
  friend Several Reciprocal(const Several& a) {
    return Each([](const V& x) { return Reciprocal(x); }, a);
  }
};

// The result of comparing two Several.
template <class V, int kCount>
struct SeveralMasks {
  typename V::batch_bool_type m[kCount];
};
template <class V, int kCount>
inline SeveralMasks<V, kCount> operator<(const Several<V, kCount>& a, const Several<V, kCount>& b) {
  SeveralMasks<V, kCount> result;
  Unrolled<kCount>([&](auto i) { result.m[i] = a.v[i] < b.v[i]; });
  return result;
}

template <class V, int kCount>
struct Elementary<Several<V, kCount>> {
  using T = Several<V, kCount>;
  static T Select(const SeveralMasks<V, kCount>& mask, const T& a, const T& b) {
    T result;
    Unrolled<kCount>([&](auto i) { result.v[i] = Elementary<V>::Select(mask.m[i], a.v[i], b.v[i]); });
    return result;
  }
  static T Fma(const T& a, const T& b, const T& c) {
    return T::Each([](const V& x, const V& y, const V& z) { return Elementary<V>::Fma(x, y, z); }, a, b, c);
  }
  static T Fnma(const T& a, const T& b, const T& c) {
    return T::Each([](const V& x, const V& y, const V& z) { return Elementary<V>::Fnma(x, y, z); }, a, b, c);
  }
  static T Max(const T& a, const T& b) {
    return T::Each([](const V& x, const V& y) { return Elementary<V>::Max(x, y); }, a, b);
  }
  static T Min(const T& a, const T& b) {
    return T::Each([](const V& x, const V& y) { return Elementary<V>::Min(x, y); }, a, b);
  }
};

// Values of N fields (images, or functions of images) at the same pixels.
template <int N, class T>
struct Fields {
  T f[N];
};

}  // namespace VESTA_ISA
}  // namespace vesta
