// SPDX-License-Identifier: Apache-2.0
// The derivatives of a Dual<T, N> with N > 1, in SIMD registers. Host code only.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <utility>

#include "kernels/math/dual.h"

namespace vesta {
inline namespace VESTA_ISA {

// The compiler's vector type that holds kWidth derivatives of type T, float or double. Its width is the one of the
// target instruction set, SSE2 by default.
template <class T>
struct DerivativeVector {
#if defined(__AVX512F__)
  static constexpr int kBytes = 64;
#elif defined(__AVX__)
  static constexpr int kBytes = 32;
#else
  static constexpr int kBytes = 16;
#endif
  static constexpr int kWidth = kBytes / static_cast<int>(sizeof(T));
  // Aligned as for SSE2, so that small dual numbers have little padding and allocators need not align further.
  typedef T Type __attribute__((vector_size(kBytes), aligned(16)));
  using Mask = decltype(Type() == Type());
  using Condition = bool;  // the type of a comparison of two values of type T
  static Type Select(bool condition, const Type& a, const Type& b) { return condition ? a : b; }
  static Type Select(const Mask& mask, const Type& a, const Type& b) { return mask ? a : b; }
  static bool AllZero(const Mask& zero) {
    for (int i = 0; i < kWidth; ++i) {
      if (!zero[i]) return false;
    }
    return true;
  }
};

// N numbers with the operations of a vector space, in vectors of the type DerivativeVector. Entries beyond N are
// padding. Division multiplies by the reciprocal. The functions are always inlined, because calls would copy the
// numbers through memory. All files of a program that use Derivatives must be compiled for the same instruction set.
template <class T, int N>
struct Derivatives {
  static constexpr int kWidth = DerivativeVector<T>::kWidth;
  static constexpr int kParts = (N + kWidth - 1) / kWidth;
  using Part = typename DerivativeVector<T>::Type;
  // True for the entries that are 0. Padding may also be true.
  struct Mask {
    typename DerivativeVector<T>::Mask parts[kParts];
  };

  Part parts[kParts];

  Derivatives() = default;
  explicit Derivatives(const T& value) {
    *this = Map([&](std::size_t) { return value - Part(); });
  }
  // 1 for entry k, 0 for the others. Made in registers, because after a write to one entry in memory, the processor
  // would wait before it can read the whole part.
  [[gnu::always_inline]] static Derivatives Unit(int k) {
    return Map([&](std::size_t i) {
      Part part = {};
      for (int j = 0; j < kWidth; ++j) part[j] = static_cast<int>(i) * kWidth + j == k ? T(1) : T(0);
      return part;
    });
  }
  T& operator[](int i) { return reinterpret_cast<T*>(parts)[i]; }
  const T& operator[](int i) const { return reinterpret_cast<const T*>(parts)[i]; }

  [[gnu::always_inline]] friend Derivatives operator-(const Derivatives& x) {
    return Map([&](std::size_t i) { return -x.parts[i]; });
  }
  [[gnu::always_inline]] friend Derivatives operator+(const Derivatives& x, const Derivatives& y) {
    return Map([&](std::size_t i) { return x.parts[i] + y.parts[i]; });
  }
  [[gnu::always_inline]] friend Derivatives operator-(const Derivatives& x, const Derivatives& y) {
    return Map([&](std::size_t i) { return x.parts[i] - y.parts[i]; });
  }
  [[gnu::always_inline]] friend Derivatives operator*(const Derivatives& x, const T& y) {
    return Map([&](std::size_t i) { return x.parts[i] * y; });
  }
  [[gnu::always_inline]] friend Derivatives operator*(const T& x, const Derivatives& y) { return y * x; }
  [[gnu::always_inline]] friend Derivatives operator/(const Derivatives& x, const T& y) { return x * (T(1) / y); }
  friend Mask operator==(const Derivatives& x, const T& y) {
    Mask mask;
    for (int i = 0; i < kParts; ++i) mask.parts[i] = x.parts[i] == y;
    return mask;
  }
  friend bool IsZero(const Derivatives& x) {
    auto zero = x.parts[0] == T(0);
    for (int i = 1; i < kParts; ++i) zero = zero & (x.parts[i] == T(0));
    return DerivativeVector<T>::AllZero(zero);
  }
  template <class Char, class Traits>
  friend std::basic_ostream<Char, Traits>& operator<<(std::basic_ostream<Char, Traits>& out, const Derivatives& x) {
    for (int i = 0; i < N; ++i) out << (i > 0 ? ", " : "") << x[i];
    return out;
  }

  // f(0), f(1), ..., f(kParts - 1). Unrolled, because the parts of a loop would stay in memory.
  template <class F>
  [[gnu::always_inline]] static Derivatives Map(const F& f) {
    return Map(f, std::make_index_sequence<kParts>());
  }
  template <class F, std::size_t... i>
  [[gnu::always_inline]] static Derivatives Map(const F& f, std::index_sequence<i...>) {
    Derivatives result;
    ((result.parts[i] = f(i)), ...);
    return result;
  }
};

template <class T, int N>
struct Elementary<Derivatives<T, N>> {
  using D = Derivatives<T, N>;
  using Vector = DerivativeVector<T>;
  [[gnu::always_inline]] static D Select(const typename Vector::Condition& condition, const D& a, const D& b) {
    return D::Map([&](std::size_t i) { return Vector::Select(condition, a.parts[i], b.parts[i]); });
  }
  [[gnu::always_inline]] static D Select(const typename D::Mask& condition, const D& a, const D& b) {
    return D::Map([&](std::size_t i) { return Vector::Select(condition.parts[i], a.parts[i], b.parts[i]); });
  }
  [[gnu::always_inline]] static D Fma(const D& a, const T& b, const D& c) {
    return D::Map([&](std::size_t i) { return a.parts[i] * b + c.parts[i]; });
  }
  [[gnu::always_inline]] static D Fma(const T& a, const D& b, const D& c) { return Fma(b, a, c); }
  [[gnu::always_inline]] static D Fnma(const D& a, const T& b, const D& c) {
    return D::Map([&](std::size_t i) { return c.parts[i] - a.parts[i] * b; });
  }
  [[gnu::always_inline]] static D Fnma(const T& a, const D& b, const D& c) { return Fnma(b, a, c); }
};

// Derivative i of a dual number, 0 <= i < N; also for N = 1.
template <class D>
auto& DerivativeOf(D& x, int i) {
  if constexpr (D::kDerivatives == 1) {
    return x.v;
  } else {
    return x.v[i];
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta
