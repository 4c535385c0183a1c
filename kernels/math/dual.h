// Dual numbers: a value and one directional derivative. The forward mode of every tangent in the project; unlike
// ceres::Jet it compiles for the device and nests around SIMD batches.
#pragma once

#include <type_traits>

#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

// a + v * eps with eps^2 = 0. Comparisons, and questions such as isfinite, look at the value alone. The members have
// the names of ceres::Jet's, so that templates that open a Jet (ceres::CubicInterpolator) take this too.
template <class T>
struct Dual {
  T a;
  T v;

  Dual() = default;
  // By value: device code may not take the address of a namespace constant, as Dual(kConstant) otherwise would.
  VESTA_HD Dual(T value) : a(value), v(T(0)) {}
  VESTA_HD Dual(const T& value, const T& derivative) : a(value), v(derivative) {}
  // Constants: Dual<batch>(0.5f), Dual<double>(2).
  template <class U>
  requires(std::is_arithmetic_v<U> && !std::is_same_v<U, T>) VESTA_HD explicit Dual(U value) : a(T(value)), v(T(0)) {}

  VESTA_HD Dual& operator+=(const Dual& b) { return *this = *this + b; }
  VESTA_HD Dual& operator-=(const Dual& b) { return *this = *this - b; }
  VESTA_HD Dual& operator*=(const Dual& b) { return *this = *this * b; }
  VESTA_HD Dual& operator/=(const Dual& b) { return *this = *this / b; }

  VESTA_HD friend Dual operator+(const Dual& a) { return a; }
  VESTA_HD friend Dual operator-(const Dual& a) { return {-a.a, -a.v}; }
  VESTA_HD friend Dual operator+(const Dual& a, const Dual& b) { return {a.a + b.a, a.v + b.v}; }
  VESTA_HD friend Dual operator-(const Dual& a, const Dual& b) { return {a.a - b.a, a.v - b.v}; }
  VESTA_HD friend Dual operator*(const Dual& a, const Dual& b) { return {a.a * b.a, Fma(a.v, b.a, a.a * b.v)}; }
  VESTA_HD friend Dual operator/(const Dual& a, const Dual& b) {
    const T quotient = a.a / b.a;
    return {quotient, (a.v - quotient * b.v) / b.a};
  }
  VESTA_HD friend auto operator<(const Dual& a, const Dual& b) { return a.a < b.a; }
  VESTA_HD friend auto operator>(const Dual& a, const Dual& b) { return a.a > b.a; }
  VESTA_HD friend auto operator<=(const Dual& a, const Dual& b) { return a.a <= b.a; }
  VESTA_HD friend auto operator>=(const Dual& a, const Dual& b) { return a.a >= b.a; }
  VESTA_HD friend auto operator==(const Dual& a, const Dual& b) { return a.a == b.a; }

  VESTA_HD friend Dual exp(const Dual& a) {
    using std::exp;
    const T e = exp(a.a);
    return {e, e * a.v};
  }
  VESTA_HD friend Dual log(const Dual& a) {
    using std::log;
    return {log(a.a), a.v / a.a};
  }
  VESTA_HD friend Dual sqrt(const Dual& a) {
    using std::sqrt;
    const T root = sqrt(a.a);
    return {root, a.v / (root + root)};
  }
  VESTA_HD friend Dual sin(const Dual& a) {
    using std::cos, std::sin;
    return {sin(a.a), cos(a.a) * a.v};
  }
  VESTA_HD friend Dual cos(const Dual& a) {
    using std::cos, std::sin;
    return {cos(a.a), -sin(a.a) * a.v};
  }
  VESTA_HD friend Dual tan(const Dual& a) {
    using std::tan;
    const T t = tan(a.a);
    return {t, (T(1) + t * t) * a.v};
  }
  VESTA_HD friend Dual sinh(const Dual& a) {
    using std::cosh, std::sinh;
    return {sinh(a.a), cosh(a.a) * a.v};
  }
  VESTA_HD friend Dual cosh(const Dual& a) {
    using std::cosh, std::sinh;
    return {cosh(a.a), sinh(a.a) * a.v};
  }
  VESTA_HD friend Dual tanh(const Dual& a) {
    using std::tanh;
    const T t = tanh(a.a);
    return {t, (T(1) - t * t) * a.v};
  }
  VESTA_HD friend Dual asin(const Dual& a) {
    using std::asin, std::sqrt;
    return {asin(a.a), a.v / sqrt(T(1) - a.a * a.a)};
  }
  VESTA_HD friend Dual acos(const Dual& a) {
    using std::acos, std::sqrt;
    return {acos(a.a), -a.v / sqrt(T(1) - a.a * a.a)};
  }
  VESTA_HD friend Dual hypot(const Dual& a, const Dual& b) {
    using std::hypot;
    const T h = hypot(a.a, b.a);
    return {h, (a.a * a.v + b.a * b.v) / h};
  }
  VESTA_HD friend Dual atan(const Dual& a) {
    using std::atan;
    return {atan(a.a), a.v / (T(1) + a.a * a.a)};
  }
  VESTA_HD friend Dual atan2(const Dual& y, const Dual& x) {
    using std::atan2;
    return {atan2(y.a, x.a), (x.a * y.v - y.a * x.v) / (x.a * x.a + y.a * y.a)};
  }
  VESTA_HD friend Dual abs(const Dual& a) { return {Select(a.a < T(0), -a.a, a.a), Select(a.a < T(0), -a.v, a.v)}; }
  // a^b for a > 0, for a = 0 with b > 0, or for a constant b and any a that std::pow takes.
  VESTA_HD friend Dual pow(const Dual& a, const Dual& b) {
    using std::log, std::pow;
    const T value = pow(a.a, b.a);
    const T by_base = b.a * pow(a.a, b.a - T(1)) * a.v;
    // At a = 0 the value is 0 for every b > 0, while the logarithm is not finite.
    const T by_both = Select(b.v == T(0), by_base, by_base + value * log(a.a) * b.v);
    return {value, Select(a.a == T(0), by_base, by_both)};
  }

  VESTA_HD friend Dual exp2(const Dual& a) {
    using std::exp2;
    const T e = exp2(a.a);
    return {e, T(kLn2) * e * a.v};
  }
  VESTA_HD friend Dual expm1(const Dual& a) {
    using std::exp, std::expm1;
    return {expm1(a.a), exp(a.a) * a.v};
  }
  VESTA_HD friend Dual log1p(const Dual& a) {
    using std::log1p;
    return {log1p(a.a), a.v / (T(1) + a.a)};
  }
  VESTA_HD friend Dual log2(const Dual& a) {
    using std::log2;
    return {log2(a.a), a.v / (T(kLn2) * a.a)};
  }
  VESTA_HD friend Dual log10(const Dual& a) {
    using std::log10;
    return {log10(a.a), a.v / (T(kLn10) * a.a)};
  }
  VESTA_HD friend Dual cbrt(const Dual& a) {
    using std::cbrt;
    const T root = cbrt(a.a);
    return {root, a.v / (T(3) * root * root)};
  }
  VESTA_HD friend Dual erf(const Dual& a) {
    using std::erf, std::exp;
    return {erf(a.a), T(kTwoOverRootPi) * exp(-a.a * a.a) * a.v};
  }
  VESTA_HD friend Dual erfc(const Dual& a) {
    using std::erfc, std::exp;
    return {erfc(a.a), -T(kTwoOverRootPi) * exp(-a.a * a.a) * a.v};
  }
  VESTA_HD friend Dual asinh(const Dual& a) {
    using std::asinh, std::sqrt;
    return {asinh(a.a), a.v / sqrt(T(1) + a.a * a.a)};
  }
  VESTA_HD friend Dual acosh(const Dual& a) {
    using std::acosh, std::sqrt;
    return {acosh(a.a), a.v / sqrt((a.a - T(1)) * (a.a + T(1)))};
  }
  VESTA_HD friend Dual atanh(const Dual& a) {
    using std::atanh;
    return {atanh(a.a), a.v / ((T(1) - a.a) * (T(1) + a.a))};
  }
  // Constant between whole numbers.
  VESTA_HD friend Dual floor(const Dual& a) {
    using std::floor;
    return {floor(a.a), T(0)};
  }
  VESTA_HD friend Dual ceil(const Dual& a) {
    using std::ceil;
    return {ceil(a.a), T(0)};
  }
  // Of a value that is NaN and one that is not, the one that is not.
  VESTA_HD friend Dual fmax(const Dual& a, const Dual& b) { return Select(a.a < b.a, b, Select(a.a == a.a, a, b)); }
  VESTA_HD friend Dual fmin(const Dual& a, const Dual& b) { return Select(b.a < a.a, b, Select(a.a == a.a, a, b)); }
  VESTA_HD friend auto isfinite(const Dual& a) {
    using std::isfinite;
    return isfinite(a.a);
  }
  VESTA_HD friend auto isnan(const Dual& a) {
    using std::isnan;
    return isnan(a.a);
  }
  VESTA_HD friend auto isinf(const Dual& a) {
    using std::isinf;
    return isinf(a.a);
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
  // The value rounds as that of plain T does, so that a cut-off never flips between a function and its tangent.
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
