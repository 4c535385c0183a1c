// Dual numbers: a value and one directional derivative. The forward mode of every tangent in the project; unlike
// ceres::Jet it compiles for the device and nests around SIMD batches.
#pragma once

#include <type_traits>

#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

// v + d * eps with eps^2 = 0. Comparisons look at the value alone.
template <class T>
struct Dual {
  T v;
  T d;

  Dual() = default;
  // By value: device code may not take the address of a namespace constant, as Dual(kConstant) otherwise would.
  VESTA_HD Dual(T value) : v(value), d(T(0)) {}
  VESTA_HD Dual(const T& value, const T& derivative) : v(value), d(derivative) {}
  // Constants: Dual<batch>(0.5f), Dual<double>(2).
  template <class U>
  requires(std::is_arithmetic_v<U> && !std::is_same_v<U, T>) VESTA_HD explicit Dual(U value) : v(T(value)), d(T(0)) {}

  VESTA_HD Dual& operator+=(const Dual& b) { return *this = *this + b; }
  VESTA_HD Dual& operator-=(const Dual& b) { return *this = *this - b; }
  VESTA_HD Dual& operator*=(const Dual& b) { return *this = *this * b; }
  VESTA_HD Dual& operator/=(const Dual& b) { return *this = *this / b; }

  VESTA_HD friend Dual operator-(const Dual& a) { return {-a.v, -a.d}; }
  VESTA_HD friend Dual operator+(const Dual& a, const Dual& b) { return {a.v + b.v, a.d + b.d}; }
  VESTA_HD friend Dual operator-(const Dual& a, const Dual& b) { return {a.v - b.v, a.d - b.d}; }
  VESTA_HD friend Dual operator*(const Dual& a, const Dual& b) { return {a.v * b.v, Fma(a.d, b.v, a.v * b.d)}; }
  VESTA_HD friend Dual operator/(const Dual& a, const Dual& b) {
    const T quotient = a.v / b.v;
    return {quotient, (a.d - quotient * b.d) / b.v};
  }
  VESTA_HD friend auto operator<(const Dual& a, const Dual& b) { return a.v < b.v; }
  VESTA_HD friend auto operator>(const Dual& a, const Dual& b) { return a.v > b.v; }
  VESTA_HD friend auto operator<=(const Dual& a, const Dual& b) { return a.v <= b.v; }
  VESTA_HD friend auto operator>=(const Dual& a, const Dual& b) { return a.v >= b.v; }
  VESTA_HD friend auto operator==(const Dual& a, const Dual& b) { return a.v == b.v; }

  VESTA_HD friend Dual exp(const Dual& a) {
    using std::exp;
    const T e = exp(a.v);
    return {e, e * a.d};
  }
  VESTA_HD friend Dual log(const Dual& a) {
    using std::log;
    return {log(a.v), a.d / a.v};
  }
  VESTA_HD friend Dual sqrt(const Dual& a) {
    using std::sqrt;
    const T root = sqrt(a.v);
    return {root, a.d / (root + root)};
  }
  VESTA_HD friend Dual sin(const Dual& a) {
    using std::cos, std::sin;
    return {sin(a.v), cos(a.v) * a.d};
  }
  VESTA_HD friend Dual cos(const Dual& a) {
    using std::cos, std::sin;
    return {cos(a.v), -sin(a.v) * a.d};
  }
  VESTA_HD friend Dual tan(const Dual& a) {
    using std::tan;
    const T t = tan(a.v);
    return {t, (T(1) + t * t) * a.d};
  }
  VESTA_HD friend Dual sinh(const Dual& a) {
    using std::cosh, std::sinh;
    return {sinh(a.v), cosh(a.v) * a.d};
  }
  VESTA_HD friend Dual cosh(const Dual& a) {
    using std::cosh, std::sinh;
    return {cosh(a.v), sinh(a.v) * a.d};
  }
  VESTA_HD friend Dual tanh(const Dual& a) {
    using std::tanh;
    const T t = tanh(a.v);
    return {t, (T(1) - t * t) * a.d};
  }
  VESTA_HD friend Dual asin(const Dual& a) {
    using std::asin, std::sqrt;
    return {asin(a.v), a.d / sqrt(T(1) - a.v * a.v)};
  }
  VESTA_HD friend Dual acos(const Dual& a) {
    using std::acos, std::sqrt;
    return {acos(a.v), -a.d / sqrt(T(1) - a.v * a.v)};
  }
  VESTA_HD friend Dual hypot(const Dual& a, const Dual& b) {
    using std::hypot;
    const T h = hypot(a.v, b.v);
    return {h, (a.v * a.d + b.v * b.d) / h};
  }
  VESTA_HD friend Dual atan(const Dual& a) {
    using std::atan;
    return {atan(a.v), a.d / (T(1) + a.v * a.v)};
  }
  VESTA_HD friend Dual atan2(const Dual& y, const Dual& x) {
    using std::atan2;
    return {atan2(y.v, x.v), (x.v * y.d - y.v * x.d) / (x.v * x.v + y.v * y.v)};
  }
  VESTA_HD friend Dual abs(const Dual& a) { return {Select(a.v < T(0), -a.v, a.v), Select(a.v < T(0), -a.d, a.d)}; }
  // a^b for a > 0, for a = 0 with b > 0, or for a constant b and any a that std::pow takes.
  VESTA_HD friend Dual pow(const Dual& a, const Dual& b) {
    using std::log, std::pow;
    const T value = pow(a.v, b.v);
    const T by_base = b.v * pow(a.v, b.v - T(1)) * a.d;
    // At a = 0 the value is 0 for every b > 0, while the logarithm is not finite.
    const T by_both = Select(b.d == T(0), by_base, by_base + value * log(a.v) * b.d);
    return {value, Select(a.v == T(0), by_base, by_both)};
  }
};

template <class T>
struct Elementary<Dual<T>> {
  template <class Mask>
  VESTA_HD static Dual<T> Select(const Mask& condition, const Dual<T>& a, const Dual<T>& b) {
    return {Elementary<T>::Select(condition, a.v, b.v), Elementary<T>::Select(condition, a.d, b.d)};
  }
  // The value rounds as that of plain T does, so that a cut-off never flips between a function and its tangent.
  VESTA_HD static Dual<T> Fma(const Dual<T>& a, const Dual<T>& b, const Dual<T>& c) {
    using E = Elementary<T>;
    return {E::Fma(a.v, b.v, c.v), E::Fma(a.d, b.v, E::Fma(a.v, b.d, c.d))};
  }
  VESTA_HD static Dual<T> Fnma(const Dual<T>& a, const Dual<T>& b, const Dual<T>& c) {
    using E = Elementary<T>;
    return {E::Fnma(a.v, b.v, c.v), E::Fnma(a.d, b.v, E::Fnma(a.v, b.d, c.d))};
  }
  VESTA_HD static Dual<T> Max(const Dual<T>& a, const Dual<T>& b) { return Select(a < b, b, a); }
  VESTA_HD static Dual<T> Min(const Dual<T>& a, const Dual<T>& b) { return Select(b < a, b, a); }
};

}  // namespace VESTA_ISA
}  // namespace vesta
