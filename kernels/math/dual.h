// SPDX-License-Identifier: Apache-2.0
// Dual numbers: a value and one directional derivative, used for all forward-mode derivatives of the project. Unlike
// ceres::Jet, they compile for the device and accept SIMD batches as scalars.
#pragma once

#include <type_traits>

#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

// a + v * eps with eps^2 = 0. Comparisons and tests such as isfinite use only the value. The members are named as in
// ceres::Jet, so that templates that access a Jet's members (ceres::CubicInterpolator) accept this type too.
template <class T>
struct Dual {
  T a;
  T v;

  Dual() = default;
  // Takes the value by copy: in Dual(kConstant), device code may not take the address of a namespace-scope constant.
  VESTA_HD Dual(T value) : a(value), v(T(0)) {}
  VESTA_HD Dual(const T& value, const T& derivative) : a(value), v(derivative) {}
  // Constants: Dual<batch>(0.5f), Dual<double>(2).
  template <class U>
  requires(std::is_arithmetic_v<U> && !std::is_same_v<U, T>) VESTA_HD explicit Dual(U value) : a(T(value)), v(T(0)) {}

  VESTA_HD Dual& operator+=(const Dual& b) { return *this = *this + b; }
  VESTA_HD Dual& operator-=(const Dual& b) { return *this = *this - b; }
  VESTA_HD Dual& operator*=(const Dual& b) { return *this = *this * b; }
  VESTA_HD Dual& operator/=(const Dual& b) { return *this = *this / b; }

  VESTA_HD friend Dual operator+(const Dual& x) { return x; }
  VESTA_HD friend Dual operator-(const Dual& x) { return {-x.a, -x.v}; }
  VESTA_HD friend Dual operator+(const Dual& x, const Dual& y) { return {x.a + y.a, x.v + y.v}; }
  VESTA_HD friend Dual operator-(const Dual& x, const Dual& y) { return {x.a - y.a, x.v - y.v}; }
  VESTA_HD friend Dual operator*(const Dual& x, const Dual& y) { return {x.a * y.a, Fma(x.v, y.a, x.a * y.v)}; }
  VESTA_HD friend Dual operator/(const Dual& x, const Dual& y) {
    const T quotient = x.a / y.a;
    return {quotient, (x.v - quotient * y.v) / y.a};
  }
  VESTA_HD friend auto operator<(const Dual& x, const Dual& y) { return x.a < y.a; }
  VESTA_HD friend auto operator>(const Dual& x, const Dual& y) { return x.a > y.a; }
  VESTA_HD friend auto operator<=(const Dual& x, const Dual& y) { return x.a <= y.a; }
  VESTA_HD friend auto operator>=(const Dual& x, const Dual& y) { return x.a >= y.a; }
  VESTA_HD friend auto operator==(const Dual& x, const Dual& y) { return x.a == y.a; }

  VESTA_HD friend Dual exp(const Dual& x) {
    using std::exp;
    const T e = exp(x.a);
    return {e, e * x.v};
  }
  VESTA_HD friend Dual log(const Dual& x) {
    using std::log;
    return {log(x.a), x.v / x.a};
  }
  VESTA_HD friend Dual sqrt(const Dual& x) {
    using std::sqrt;
    const T root = sqrt(x.a);
    return {root, x.v / (root + root)};
  }
  VESTA_HD friend Dual sin(const Dual& x) {
    using std::cos, std::sin;
    return {sin(x.a), cos(x.a) * x.v};
  }
  VESTA_HD friend Dual cos(const Dual& x) {
    using std::cos, std::sin;
    return {cos(x.a), -sin(x.a) * x.v};
  }
  VESTA_HD friend Dual tan(const Dual& x) {
    using std::tan;
    const T t = tan(x.a);
    return {t, (T(1) + t * t) * x.v};
  }
  VESTA_HD friend Dual sinh(const Dual& x) {
    using std::cosh, std::sinh;
    return {sinh(x.a), cosh(x.a) * x.v};
  }
  VESTA_HD friend Dual cosh(const Dual& x) {
    using std::cosh, std::sinh;
    return {cosh(x.a), sinh(x.a) * x.v};
  }
  VESTA_HD friend Dual tanh(const Dual& x) {
    using std::tanh;
    const T t = tanh(x.a);
    return {t, (T(1) - t * t) * x.v};
  }
  VESTA_HD friend Dual asin(const Dual& x) {
    using std::asin, std::sqrt;
    return {asin(x.a), x.v / sqrt(T(1) - x.a * x.a)};
  }
  VESTA_HD friend Dual acos(const Dual& x) {
    using std::acos, std::sqrt;
    return {acos(x.a), -x.v / sqrt(T(1) - x.a * x.a)};
  }
  VESTA_HD friend Dual hypot(const Dual& x, const Dual& y) {
    using std::hypot;
    const T h = hypot(x.a, y.a);
    return {h, (x.a * x.v + y.a * y.v) / h};
  }
  VESTA_HD friend Dual atan(const Dual& x) {
    using std::atan;
    return {atan(x.a), x.v / (T(1) + x.a * x.a)};
  }
  VESTA_HD friend Dual atan2(const Dual& y, const Dual& x) {
    using std::atan2;
    return {atan2(y.a, x.a), (x.a * y.v - y.a * x.v) / (x.a * x.a + y.a * y.a)};
  }
  VESTA_HD friend Dual abs(const Dual& x) { return {Select(x.a < T(0), -x.a, x.a), Select(x.a < T(0), -x.v, x.v)}; }
  // x^y for x > 0, for x = 0 with y > 0, or for constant y and any x in the domain of std::pow.
  VESTA_HD friend Dual pow(const Dual& x, const Dual& y) {
    using std::log, std::pow;
    const T value = pow(x.a, y.a);
    const T by_base = y.a * pow(x.a, y.a - T(1)) * x.v;
    // At x = 0 the derivative with respect to y is 0 for every y > 0, but the logarithm is not finite.
    const T by_both = Select(y.v == T(0), by_base, by_base + value * log(x.a) * y.v);
    return {value, Select(x.a == T(0), by_base, by_both)};
  }

  VESTA_HD friend Dual exp2(const Dual& x) {
    using std::exp2;
    const T e = exp2(x.a);
    return {e, T(kLn2) * e * x.v};
  }
  VESTA_HD friend Dual expm1(const Dual& x) {
    using std::exp, std::expm1;
    return {expm1(x.a), exp(x.a) * x.v};
  }
  VESTA_HD friend Dual log1p(const Dual& x) {
    using std::log1p;
    return {log1p(x.a), x.v / (T(1) + x.a)};
  }
  VESTA_HD friend Dual log2(const Dual& x) {
    using std::log2;
    return {log2(x.a), x.v / (T(kLn2) * x.a)};
  }
  VESTA_HD friend Dual log10(const Dual& x) {
    using std::log10;
    return {log10(x.a), x.v / (T(kLn10) * x.a)};
  }
  VESTA_HD friend Dual cbrt(const Dual& x) {
    using std::cbrt;
    const T root = cbrt(x.a);
    return {root, x.v / (T(3) * root * root)};
  }
  VESTA_HD friend Dual erf(const Dual& x) {
    using std::erf, std::exp;
    return {erf(x.a), T(kTwoOverRootPi) * exp(-x.a * x.a) * x.v};
  }
  VESTA_HD friend Dual erfc(const Dual& x) {
    using std::erfc, std::exp;
    return {erfc(x.a), -T(kTwoOverRootPi) * exp(-x.a * x.a) * x.v};
  }
  VESTA_HD friend Dual asinh(const Dual& x) {
    using std::asinh, std::sqrt;
    return {asinh(x.a), x.v / sqrt(T(1) + x.a * x.a)};
  }
  VESTA_HD friend Dual acosh(const Dual& x) {
    using std::acosh, std::sqrt;
    return {acosh(x.a), x.v / sqrt((x.a - T(1)) * (x.a + T(1)))};
  }
  VESTA_HD friend Dual atanh(const Dual& x) {
    using std::atanh;
    return {atanh(x.a), x.v / ((T(1) - x.a) * (T(1) + x.a))};
  }
  // Piecewise constant, so the derivative is 0.
  VESTA_HD friend Dual floor(const Dual& x) {
    using std::floor;
    return {floor(x.a), T(0)};
  }
  VESTA_HD friend Dual ceil(const Dual& x) {
    using std::ceil;
    return {ceil(x.a), T(0)};
  }
  // If one argument is NaN, the result is the other one.
  VESTA_HD friend Dual fmax(const Dual& x, const Dual& y) { return Select(x.a < y.a, y, Select(x.a == x.a, x, y)); }
  VESTA_HD friend Dual fmin(const Dual& x, const Dual& y) { return Select(y.a < x.a, y, Select(x.a == x.a, x, y)); }
  VESTA_HD friend auto isfinite(const Dual& x) {
    using std::isfinite;
    return isfinite(x.a);
  }
  VESTA_HD friend auto isnan(const Dual& x) {
    using std::isnan;
    return isnan(x.a);
  }
  VESTA_HD friend auto isinf(const Dual& x) {
    using std::isinf;
    return isinf(x.a);
  }

 private:
  static constexpr double kLn2 = 0.69314718055994530942, kLn10 = 2.30258509299404568402;
  static constexpr double kTwoOverRootPi = 1.12837916709551257390;
};

template <class T>
struct Elementary<Dual<T>> {
  template <class Mask>
  VESTA_HD static Dual<T> Select(const Mask& condition, const Dual<T>& a, const Dual<T>& b) {
    return {Elementary<T>::Select(condition, a.a, b.a), Elementary<T>::Select(condition, a.v, b.v)};
  }
  // The value is rounded exactly as for plain T. Comparisons with a threshold therefore never differ between a function
  // and its derivative.
  VESTA_HD static Dual<T> Fma(const Dual<T>& a, const Dual<T>& b, const Dual<T>& c) {
    using E = Elementary<T>;
    return {E::Fma(a.a, b.a, c.a), E::Fma(a.v, b.a, E::Fma(a.a, b.v, c.v))};
  }
  VESTA_HD static Dual<T> Fnma(const Dual<T>& a, const Dual<T>& b, const Dual<T>& c) {
    using E = Elementary<T>;
    return {E::Fnma(a.a, b.a, c.a), E::Fnma(a.v, b.a, E::Fnma(a.a, b.v, c.v))};
  }
  VESTA_HD static Dual<T> Max(const Dual<T>& a, const Dual<T>& b) { return Select(a < b, b, a); }
  VESTA_HD static Dual<T> Min(const Dual<T>& a, const Dual<T>& b) { return Select(b < a, b, a); }
};

}  // namespace VESTA_ISA
}  // namespace vesta
