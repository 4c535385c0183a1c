// SPDX-License-Identifier: Apache-2.0
// Dual numbers: a value and its derivatives in N directions, for all forward-mode derivatives of the project. Unlike
// ceres::Jet, dual numbers with one derivative compile for the device and accept SIMD batches as scalars.
#pragma once

#include <cmath>
#include <concepts>
#include <iosfwd>
#include <limits>
#include <numeric>
#include <type_traits>

#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

// N derivatives of one value (kernels/math/derivatives.h, to be included by users of Dual<T, N>).
template <class T, int N>
struct Derivatives;

// a + v * eps with eps^2 = 0. v is one derivative of type T, or N > 1 of them, v[0] to v[N - 1]. Comparisons and tests
// such as isfinite use only the value. Members are named as in ceres::Jet, so that templates that access them
// (ceres::CubicInterpolator) accept this type.
template <class T, int N = 1>
struct Dual {
  static constexpr int kDerivatives = N;
  using Derivative = std::conditional_t<N == 1, T, Derivatives<T, N>>;
  T a;
  Derivative v;

  Dual() = default;
  // By copy: in Dual(kConstant), device code may not take the address of a namespace-scope constant.
  VESTA_HD constexpr Dual(T value) : a(value), v(T(0)) {}
  VESTA_HD constexpr Dual(const T& value, const Derivative& derivative) : a(value), v(derivative) {}
  // Constants: Dual<batch>(0.5f), Dual<double>(2).
  template <class U>
  requires(std::is_arithmetic_v<U> && !std::is_same_v<U, T>) VESTA_HD constexpr explicit Dual(U value)
      : a(T(value)), v(T(0)) {}

  template <std::convertible_to<Dual> U>
  VESTA_HD Dual& operator+=(const U& b) {
    return *this = *this + b;
  }
  template <std::convertible_to<Dual> U>
  VESTA_HD Dual& operator-=(const U& b) {
    return *this = *this - b;
  }
  template <std::convertible_to<Dual> U>
  VESTA_HD Dual& operator*=(const U& b) {
    return *this = *this * b;
  }
  template <std::convertible_to<Dual> U>
  VESTA_HD Dual& operator/=(const U& b) {
    return *this = *this / b;
  }

  VESTA_HD friend Dual operator+(const Dual& x) { return x; }
  VESTA_HD friend Dual operator-(const Dual& x) { return {-x.a, -x.v}; }
  VESTA_HD friend Dual operator+(const Dual& x, const Dual& y) { return {x.a + y.a, x.v + y.v}; }
  VESTA_HD friend Dual operator-(const Dual& x, const Dual& y) { return {x.a - y.a, x.v - y.v}; }
  VESTA_HD friend Dual operator*(const Dual& x, const Dual& y) {
    return {x.a * y.a, Elementary<Derivative>::Fma(x.v, y.a, x.a * y.v)};
  }
  VESTA_HD friend Dual operator/(const Dual& x, const Dual& y) {
    const T quotient = x.a / y.a;
    return {quotient, (x.v - quotient * y.v) / y.a};
  }
  // Sums and products with constants, for N > 1. For N = 1, constants become dual numbers, because SIMD batches need
  // the same bits and a derivative of 0 costs little.
  VESTA_HD friend Dual operator+(const Dual& x, const T& y) requires(N > 1) { return {x.a + y, x.v}; }
  VESTA_HD friend Dual operator+(const T& x, const Dual& y) requires(N > 1) { return {x + y.a, y.v}; }
  VESTA_HD friend Dual operator-(const Dual& x, const T& y) requires(N > 1) { return {x.a - y, x.v}; }
  VESTA_HD friend Dual operator-(const T& x, const Dual& y) requires(N > 1) { return {x - y.a, -y.v}; }
  VESTA_HD friend Dual operator*(const Dual& x, const T& y) requires(N > 1) { return {x.a * y, x.v * y}; }
  VESTA_HD friend Dual operator*(const T& x, const Dual& y) requires(N > 1) { return {x * y.a, x * y.v}; }
  VESTA_HD friend Dual operator/(const Dual& x, const T& y) requires(N > 1) { return {x.a / y, x.v / y}; }
  VESTA_HD friend auto operator<(const Dual& x, const Dual& y) { return x.a < y.a; }
  VESTA_HD friend auto operator>(const Dual& x, const Dual& y) { return x.a > y.a; }
  VESTA_HD friend auto operator<=(const Dual& x, const Dual& y) { return x.a <= y.a; }
  VESTA_HD friend auto operator>=(const Dual& x, const Dual& y) { return x.a >= y.a; }
  VESTA_HD friend auto operator==(const Dual& x, const Dual& y) { return x.a == y.a; }
  // Written out, because C++20 derives != only from an operator== that returns bool. SIMD lanes return a mask.
  VESTA_HD friend auto operator!=(const Dual& x, const Dual& y) { return x.a != y.a; }

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
    return {h, x.a / h * x.v + y.a / h * y.v};
  }
  friend Dual hypot(const Dual& x, const Dual& y, const Dual& z) {
    using std::hypot;
    const T h = hypot(x.a, y.a, z.a);
    return {h, x.a / h * x.v + y.a / h * y.v + z.a / h * z.v};
  }
  VESTA_HD friend Dual atan(const Dual& x) {
    using std::atan;
    return {atan(x.a), x.v / (T(1) + x.a * x.a)};
  }
  VESTA_HD friend Dual atan2(const Dual& y, const Dual& x) {
    using std::atan2;
    return {atan2(y.a, x.a), (x.a * y.v - y.a * x.v) / (x.a * x.a + y.a * y.a)};
  }
  // At 0 and -0, the one-sided derivative on the side of the sign.
  VESTA_HD friend Dual abs(const Dual& x) {
    using std::abs, std::copysign;
    return {abs(x.a), copysign(T(1), x.a) * x.v};
  }
  VESTA_HD friend Dual copysign(const Dual& x, const Dual& y) {
    using std::copysign;
    return {copysign(x.a, y.a), copysign(T(1), x.a) * copysign(T(1), y.a) * x.v};
  }
  // x^y for x > 0, for x = 0 with y > 0, or for constant y and any x in the domain of std::pow.
  VESTA_HD friend Dual pow(const Dual& x, const Dual& y) {
    using std::log, std::pow;
    if constexpr (N > 1) {
      if (IsZero(y.v)) return pow(x, y.a);
    }
    const T value = pow(x.a, y.a);
    const Derivative by_base = y.a * pow(x.a, y.a - T(1)) * x.v;
    // At x = 0 the derivative with respect to y is 0 for every y > 0, but the logarithm is not finite.
    const Derivative by_both = Select(y.v == T(0), by_base, by_base + value * log(x.a) * y.v);
    return {value, Select(x.a == T(0), by_base, by_both)};
  }
  // A constant exponent takes half of the time.
  VESTA_HD friend Dual pow(const Dual& x, const T& y) requires(N > 1) {
    using std::pow;
    return {pow(x.a, y), y * pow(x.a, y - T(1)) * x.v};
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
    return {floor(x.a), Derivative(T(0))};
  }
  VESTA_HD friend Dual ceil(const Dual& x) {
    using std::ceil;
    return {ceil(x.a), Derivative(T(0))};
  }
  // If one argument is NaN, the result is the other one.
  VESTA_HD friend Dual fmax(const Dual& x, const Dual& y) { return Select(x.a < y.a, y, Select(x.a == x.a, x, y)); }
  VESTA_HD friend Dual fmin(const Dual& x, const Dual& y) { return Select(y.a < x.a, y, Select(x.a == x.a, x, y)); }
  friend Dual fdim(const Dual& x, const Dual& y) {
    using std::isnan;
    return isnan(x.a) || isnan(y.a) || x.a > y.a ? x - y : Dual(T(0));
  }
  friend Dual fma(const Dual& x, const Dual& y, const Dual& z) {
    using std::fma;
    return {fma(x.a, y.a, z.a), x.a * y.v + y.a * x.v + z.v};
  }
  friend Dual lerp(const Dual& x, const Dual& y, const Dual& t) {
    using std::lerp;
    return {lerp(x.a, y.a, t.a), (T(1) - t.a) * x.v + t.a * y.v + (y.a - x.a) * t.v};
  }
  friend Dual midpoint(const Dual& x, const Dual& y) {
    using std::midpoint;
    return {midpoint(x.a, y.a), T(0.5) * (x.v + y.v)};
  }
  // x^2, as std::norm.
  friend Dual norm(const Dual& x) { return x * x; }
  // Bessel functions of the first kind, as in <math.h> and std::cyl_bessel_j. The order n is constant.
  friend Dual j0(const Dual& x) { return {T(j0(x.a)), T(-j1(x.a)) * x.v}; }
  friend Dual j1(const Dual& x) { return {T(j1(x.a)), T(0.5) * T(j0(x.a) - jn(2, x.a)) * x.v}; }
  friend Dual jn(int n, const Dual& x) { return {T(jn(n, x.a)), T(0.5) * T(jn(n - 1, x.a) - jn(n + 1, x.a)) * x.v}; }
#if defined(__cpp_lib_math_special_functions)
  friend Dual cyl_bessel_j(double n, const Dual& x) {
    using std::cyl_bessel_j;
    const auto at = [&](double order) { return T(cyl_bessel_j(order, x.a)); };
    const T value = at(n);
    const T slope = n == 0 ? -at(1) : n < 1 ? T(n) / x.a * value - at(n + 1) : T(0.5) * (at(n - 1) - at(n + 1));
    return {value, slope * x.v};
  }
#endif

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
  friend auto isnormal(const Dual& x) {
    using std::isnormal;
    return isnormal(x.a);
  }
  friend auto signbit(const Dual& x) {
    using std::signbit;
    return signbit(x.a);
  }
  friend int fpclassify(const Dual& x) {
    using std::fpclassify;
    return fpclassify(x.a);
  }
  // Comparisons without floating-point exceptions.
  friend bool isless(const Dual& x, const Dual& y) {
    using std::isless;
    return isless(x.a, y.a);
  }
  friend bool islessequal(const Dual& x, const Dual& y) {
    using std::islessequal;
    return islessequal(x.a, y.a);
  }
  friend bool isgreater(const Dual& x, const Dual& y) {
    using std::isgreater;
    return isgreater(x.a, y.a);
  }
  friend bool isgreaterequal(const Dual& x, const Dual& y) {
    using std::isgreaterequal;
    return isgreaterequal(x.a, y.a);
  }
  friend bool islessgreater(const Dual& x, const Dual& y) {
    using std::islessgreater;
    return islessgreater(x.a, y.a);
  }
  friend bool isunordered(const Dual& x, const Dual& y) {
    using std::isunordered;
    return isunordered(x.a, y.a);
  }

  // Prints "[a; v]".
  template <class Char, class Traits>
  friend std::basic_ostream<Char, Traits>& operator<<(std::basic_ostream<Char, Traits>& out, const Dual& x) {
    return out << '[' << x.a << "; " << x.v << ']';
  }

 private:
  static constexpr double kLn2 = 0.69314718055994530942, kLn10 = 2.30258509299404568402;
  static constexpr double kTwoOverRootPi = 1.12837916709551257390;
};

template <class T, int N>
struct Elementary<Dual<T, N>> {
  using D = Dual<T, N>;
  using OfValue = Elementary<T>;
  using OfDerivative = Elementary<typename D::Derivative>;
  template <class Mask>
  VESTA_HD static D Select(const Mask& condition, const D& a, const D& b) {
    return {OfValue::Select(condition, a.a, b.a), OfDerivative::Select(condition, a.v, b.v)};
  }
  // The value is rounded as for plain T. Comparisons of the value with a threshold are therefore the same in a function
  // and in its derivative.
  VESTA_HD static D Fma(const D& a, const D& b, const D& c) {
    return {OfValue::Fma(a.a, b.a, c.a), OfDerivative::Fma(a.v, b.a, OfDerivative::Fma(a.a, b.v, c.v))};
  }
  VESTA_HD static D Fnma(const D& a, const D& b, const D& c) {
    return {OfValue::Fnma(a.a, b.a, c.a), OfDerivative::Fnma(a.v, b.a, OfDerivative::Fnma(a.a, b.v, c.v))};
  }
  VESTA_HD static D Max(const D& a, const D& b) { return Select(a < b, b, a); }
  VESTA_HD static D Min(const D& a, const D& b) { return Select(b < a, b, a); }
};

}  // namespace VESTA_ISA
}  // namespace vesta

// The limits of T, as dual numbers with derivative 0.
template <class T, int N>
struct std::numeric_limits<vesta::Dual<T, N>> : std::numeric_limits<T> {
 private:
  using D = vesta::Dual<T, N>;
  using Limits = std::numeric_limits<T>;

 public:
  static constexpr D min() noexcept { return D(Limits::min()); }
  static constexpr D lowest() noexcept { return D(Limits::lowest()); }
  static constexpr D max() noexcept { return D(Limits::max()); }
  static constexpr D epsilon() noexcept { return D(Limits::epsilon()); }
  static constexpr D round_error() noexcept { return D(Limits::round_error()); }
  static constexpr D infinity() noexcept { return D(Limits::infinity()); }
  static constexpr D quiet_NaN() noexcept { return D(Limits::quiet_NaN()); }
  static constexpr D signaling_NaN() noexcept { return D(Limits::signaling_NaN()); }
  static constexpr D denorm_min() noexcept { return D(Limits::denorm_min()); }
};
