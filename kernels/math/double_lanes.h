// SPDX-License-Identifier: Apache-2.0
// A SIMD vector of doubles, used as the scalar type of residual functors. Each lane belongs to a different problem
// (solver/solve_each.h). Host code only.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <iosfwd>
#include <limits>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include "kernels/math/derivatives.h"
#include "kernels/math/dual.h"
#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

// kWidth doubles, as many as fit into one vector register of the target instruction set. A comparison returns a mask
// with one truth value per lane, which `if` cannot use; use Select (kernels/math/scalar.h) instead. Arithmetic, sqrt,
// exp and abs work on all lanes at once. The other functions call the standard library for each lane.
class DoubleLanes {
 public:
#if defined(__AVX512F__)
  static constexpr int kWidth = 8;
#elif defined(__AVX__)
  static constexpr int kWidth = 4;
#else
  static constexpr int kWidth = 2;
#endif
  typedef double Vector __attribute__((vector_size(8 * kWidth)));
  typedef std::int64_t Bits __attribute__((vector_size(8 * kWidth)));

  // One truth value per lane: -1 for true, 0 for false.
  class Mask {
   public:
    Mask() = default;
    explicit Mask(const Bits& lanes) : bits(lanes) {}
    explicit Mask(bool all) : bits(Bits() - (all ? 1 : 0)) {}
    bool operator[](int lane) const { return bits[lane] != 0; }
    friend Mask operator&(const Mask& a, const Mask& b) { return Mask(a.bits & b.bits); }
    friend Mask operator|(const Mask& a, const Mask& b) { return Mask(a.bits | b.bits); }
    friend Mask operator!(const Mask& a) { return Mask(~a.bits); }
    friend Mask operator&&(const Mask& a, const Mask& b) { return a & b; }
    friend Mask operator||(const Mask& a, const Mask& b) { return a | b; }

    Bits bits;
  };

  DoubleLanes() = default;
  // The same value in all lanes.
  DoubleLanes(double value) : v(value - Vector()) {}
  explicit DoubleLanes(const Vector& lanes) : v(lanes) {}
  double operator[](int lane) const { return v[lane]; }
  double& operator[](int lane) { return reinterpret_cast<double*>(&v)[lane]; }

  DoubleLanes& operator+=(const DoubleLanes& b) { return *this = *this + b; }
  DoubleLanes& operator-=(const DoubleLanes& b) { return *this = *this - b; }
  DoubleLanes& operator*=(const DoubleLanes& b) { return *this = *this * b; }
  DoubleLanes& operator/=(const DoubleLanes& b) { return *this = *this / b; }
  friend DoubleLanes operator+(const DoubleLanes& a) { return a; }
  friend DoubleLanes operator-(const DoubleLanes& a) { return DoubleLanes(-a.v); }
  friend DoubleLanes operator+(const DoubleLanes& a, const DoubleLanes& b) { return DoubleLanes(a.v + b.v); }
  friend DoubleLanes operator-(const DoubleLanes& a, const DoubleLanes& b) { return DoubleLanes(a.v - b.v); }
  friend DoubleLanes operator*(const DoubleLanes& a, const DoubleLanes& b) { return DoubleLanes(a.v * b.v); }
  friend DoubleLanes operator/(const DoubleLanes& a, const DoubleLanes& b) { return DoubleLanes(a.v / b.v); }
  friend Mask operator<(const DoubleLanes& a, const DoubleLanes& b) { return Mask(a.v < b.v); }
  friend Mask operator>(const DoubleLanes& a, const DoubleLanes& b) { return Mask(a.v > b.v); }
  friend Mask operator<=(const DoubleLanes& a, const DoubleLanes& b) { return Mask(a.v <= b.v); }
  friend Mask operator>=(const DoubleLanes& a, const DoubleLanes& b) { return Mask(a.v >= b.v); }
  friend Mask operator==(const DoubleLanes& a, const DoubleLanes& b) { return Mask(a.v == b.v); }
  friend Mask operator!=(const DoubleLanes& a, const DoubleLanes& b) { return Mask(a.v != b.v); }

  friend DoubleLanes sqrt(const DoubleLanes& x) {
#if defined(__AVX512F__)
    return DoubleLanes(Vector(_mm512_sqrt_pd(__m512d(x.v))));
#elif defined(__AVX__)
    return DoubleLanes(Vector(_mm256_sqrt_pd(__m256d(x.v))));
#elif defined(__SSE2__)
    return DoubleLanes(Vector(_mm_sqrt_pd(__m128d(x.v))));
#else
    return EachLane(std::sqrt, x);
#endif
  }
  // For normal results, the error is below 1 unit in the last place. Results below 2^-1021 are 0.
  friend DoubleLanes exp(const DoubleLanes& x) {
    // exp(x) = 2^n exp(r) with |r| <= ln(2) / 2. Adding 1.5 * 2^52 leaves the rounded integer n in the low bits.
    constexpr double kShift = 0x1.8p52, kLog2E = 1.44269504088896340736;
    constexpr double kLn2High = 0x1.62e42fee00000p-1, kLn2Low = 0x1.a39ef35793c76p-33;  // Cody and Waite, 1980
    const Vector shifted = x.v * kLog2E + kShift;
    const Vector n = shifted - kShift;
    const Vector r = (x.v - n * kLn2High) - n * kLn2Low;
    // The Taylor polynomial of degree 13, whose remainder is below 5e-18.
    Vector p = r * (1 / 6227020800.0) + 1 / 479001600.0;
    for (const double c : {1 / 39916800.0, 1 / 3628800.0, 1 / 362880.0, 1 / 40320.0, 1 / 5040.0, 1 / 720.0, 1 / 120.0,
                           1 / 24.0, 1 / 6.0, 0.5}) {
      p = p * r + c;
    }
    p = (p * r) * r + r + 1;
    // 2^n in two factors, because n may be 1024.
    const Bits exponent = std::bit_cast<Bits>(shifted) - std::bit_cast<std::int64_t>(kShift);
    const Vector scale = std::bit_cast<Vector>((exponent + 1022) << 52);
    const Vector value = p * scale * 2;
    constexpr double kLargest = 709.782712893384, kSmallest = -707.7032713652975;
    const Vector bounded = x.v < kSmallest ? Vector() : value;
    return DoubleLanes(x.v > kLargest ? std::numeric_limits<double>::infinity() - Vector() : bounded);
  }
  friend DoubleLanes abs(const DoubleLanes& x) {
    return DoubleLanes(std::bit_cast<Vector>(std::bit_cast<Bits>(x.v) & ~kSignBit));
  }
  friend DoubleLanes fabs(const DoubleLanes& x) { return abs(x); }
  friend DoubleLanes copysign(const DoubleLanes& x, const DoubleLanes& y) {
    return DoubleLanes(
        std::bit_cast<Vector>((std::bit_cast<Bits>(x.v) & ~kSignBit) | (std::bit_cast<Bits>(y.v) & kSignBit)));
  }
  friend DoubleLanes fmax(const DoubleLanes& x, const DoubleLanes& y) {
    return DoubleLanes(x.v < y.v ? y.v : (x.v == x.v ? x.v : y.v));
  }
  friend DoubleLanes fmin(const DoubleLanes& x, const DoubleLanes& y) {
    return DoubleLanes(y.v < x.v ? y.v : (x.v == x.v ? x.v : y.v));
  }
  friend Mask isnan(const DoubleLanes& x) { return x != x; }
  friend Mask isfinite(const DoubleLanes& x) { return abs(x) <= DoubleLanes(std::numeric_limits<double>::max()); }
  friend Mask isinf(const DoubleLanes& x) { return abs(x) > DoubleLanes(std::numeric_limits<double>::max()); }

  friend DoubleLanes log(const DoubleLanes& x) { return EachLane(std::log, x); }
  friend DoubleLanes log2(const DoubleLanes& x) { return EachLane(std::log2, x); }
  friend DoubleLanes log10(const DoubleLanes& x) { return EachLane(std::log10, x); }
  friend DoubleLanes log1p(const DoubleLanes& x) { return EachLane(std::log1p, x); }
  friend DoubleLanes exp2(const DoubleLanes& x) { return EachLane(std::exp2, x); }
  friend DoubleLanes expm1(const DoubleLanes& x) { return EachLane(std::expm1, x); }
  friend DoubleLanes sin(const DoubleLanes& x) { return EachLane(std::sin, x); }
  friend DoubleLanes cos(const DoubleLanes& x) { return EachLane(std::cos, x); }
  friend DoubleLanes tan(const DoubleLanes& x) { return EachLane(std::tan, x); }
  friend DoubleLanes asin(const DoubleLanes& x) { return EachLane(std::asin, x); }
  friend DoubleLanes acos(const DoubleLanes& x) { return EachLane(std::acos, x); }
  friend DoubleLanes atan(const DoubleLanes& x) { return EachLane(std::atan, x); }
  friend DoubleLanes sinh(const DoubleLanes& x) { return EachLane(std::sinh, x); }
  friend DoubleLanes cosh(const DoubleLanes& x) { return EachLane(std::cosh, x); }
  friend DoubleLanes tanh(const DoubleLanes& x) { return EachLane(std::tanh, x); }
  friend DoubleLanes asinh(const DoubleLanes& x) { return EachLane(std::asinh, x); }
  friend DoubleLanes acosh(const DoubleLanes& x) { return EachLane(std::acosh, x); }
  friend DoubleLanes atanh(const DoubleLanes& x) { return EachLane(std::atanh, x); }
  friend DoubleLanes cbrt(const DoubleLanes& x) { return EachLane(std::cbrt, x); }
  friend DoubleLanes erf(const DoubleLanes& x) { return EachLane(std::erf, x); }
  friend DoubleLanes erfc(const DoubleLanes& x) { return EachLane(std::erfc, x); }
  friend DoubleLanes floor(const DoubleLanes& x) { return EachLane(std::floor, x); }
  friend DoubleLanes ceil(const DoubleLanes& x) { return EachLane(std::ceil, x); }
  friend DoubleLanes pow(const DoubleLanes& x, const DoubleLanes& y) { return EachLane(std::pow, x, y); }
  friend DoubleLanes atan2(const DoubleLanes& y, const DoubleLanes& x) { return EachLane(std::atan2, y, x); }
  friend DoubleLanes hypot(const DoubleLanes& x, const DoubleLanes& y) { return EachLane(std::hypot, x, y); }
  template <class Char, class Traits>
  friend std::basic_ostream<Char, Traits>& operator<<(std::basic_ostream<Char, Traits>& out, const DoubleLanes& x) {
    for (int i = 0; i < kWidth; ++i) out << (i > 0 ? " | " : "") << x[i];
    return out;
  }

  Vector v;

 private:
  static constexpr std::int64_t kSignBit = std::numeric_limits<std::int64_t>::min();
  static DoubleLanes EachLane(double (*function)(double), const DoubleLanes& x) {
    DoubleLanes result = x;
    for (int i = 0; i < kWidth; ++i) result.v[i] = function(x.v[i]);
    return result;
  }
  static DoubleLanes EachLane(double (*function)(double, double), const DoubleLanes& x, const DoubleLanes& y) {
    DoubleLanes result = x;
    for (int i = 0; i < kWidth; ++i) result.v[i] = function(x.v[i], y.v[i]);
    return result;
  }
};

template <>
struct Elementary<DoubleLanes> {
  using V = DoubleLanes;
  using Mask = DoubleLanes::Mask;
  static V Select(const Mask& condition, const V& a, const V& b) { return V(condition.bits ? a.v : b.v); }
  static V Fma(const V& a, const V& b, const V& c) { return a * b + c; }
  static V Fnma(const V& a, const V& b, const V& c) { return c - a * b; }
  static V Max(const V& a, const V& b) { return Select(a < b, b, a); }
  static V Min(const V& a, const V& b) { return Select(b < a, b, a); }
  static V MaskedExp2(const Mask& mask, const V& x) { return Select(mask, exp2(x), V(0.0)); }
  static V MaskedProduct(const Mask& mask, const V& a, const V& b) { return Select(mask, a * b, V(0.0)); }
  static V MaskedSquareRoot(const Mask& mask, const V& x) { return Select(mask, sqrt(x), V(0.0)); }
  static V Reciprocal(const V& x) { return V(1.0) / x; }
};

// Each derivative has its own vector, with one lane per problem.
template <>
struct DerivativeVector<DoubleLanes> {
  using Type = DoubleLanes;
  using Mask = DoubleLanes::Mask;
  using Condition = Mask;
  static constexpr int kWidth = 1;
  static DoubleLanes Select(const Mask& mask, const DoubleLanes& a, const DoubleLanes& b) {
    return Elementary<DoubleLanes>::Select(mask, a, b);
  }
  static bool AllZero(const Mask& zero) {
    for (int i = 0; i < DoubleLanes::kWidth; ++i) {
      if (!zero[i]) return false;
    }
    return true;
  }
};

}  // namespace VESTA_ISA
}  // namespace vesta
