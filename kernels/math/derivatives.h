// SPDX-License-Identifier: Apache-2.0
// The derivatives of a Dual<T, N> with N > 1, in SIMD registers. Host code only.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <utility>

#include "kernels/math/dual.h"

namespace vesta {
inline namespace VESTA_ISA {

// N numbers of type float or double, with the operations of a vector space. The compiler's vector types hold them, with
// the width of the compiled instruction set, SSE2 by default. Entries beyond N are padding. Division multiplies by the
// reciprocal. Functions are always inlined: calls would copy through memory. All files of a program that use
// Derivatives must have the same instruction set.
template <class T, int N>
struct Derivatives {
#if defined(__AVX512F__)
  static constexpr int kBytes = 64;
#elif defined(__AVX__)
  static constexpr int kBytes = 32;
#else
  static constexpr int kBytes = 16;
#endif
  static constexpr int kWidth = kBytes / static_cast<int>(sizeof(T));
  static constexpr int kParts = (N + kWidth - 1) / kWidth;
  // Aligned as for SSE2: little padding in small dual numbers, and no extra alignment by allocators.
  typedef T Part __attribute__((vector_size(kBytes), aligned(16)));
  // True for the entries that are 0, and for some padding.
  struct Mask {
    decltype(Part() == Part()) parts[kParts];
  };

  Part parts[kParts];

  Derivatives() = default;
  explicit Derivatives(const T& value) {
    *this = Map([&](std::size_t) { return value - Part(); });
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
    for (int i = 1; i < kParts; ++i) zero &= x.parts[i] == T(0);
    for (int i = 0; i < kWidth; ++i) {
      if (!zero[i]) return false;
    }
    return true;
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
  [[gnu::always_inline]] static D Select(bool condition, const D& a, const D& b) { return condition ? a : b; }
  [[gnu::always_inline]] static D Select(const typename D::Mask& condition, const D& a, const D& b) {
    return D::Map([&](std::size_t i) { return condition.parts[i] ? a.parts[i] : b.parts[i]; });
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
