// SPDX-License-Identifier: Apache-2.0
// Dual numbers in place of jets. Adapted from Ceres 2.1's test internal/ceres/jet_test.cc; docs/ceres_tests.md lists
// the omitted cases. tests/kernels/math/dual_test.cpp compares every function with ceres::Jet.
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "kernels/math/derivatives.h"
#include "solver/eigen.h"

namespace vesta::test {
namespace {

using D = Dual<double, 2>;
using Jet = ceres::Jet<double, 2>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

D Make(double value, double first, double second) {
  D x(value);
  x.v[0] = first, x.v[1] = second;
  return x;
}

void ExpectSameDual(const char* what, const D& a, const D& b) {
  constexpr double kTolerance = 1e-13;
  EXPECT_NEAR(a.a, b.a, kTolerance * std::max(1.0, std::abs(b.a))) << what;
  for (int k = 0; k < 2; ++k) {
    EXPECT_NEAR(a.v[k], b.v[k], kTolerance * std::max(1.0, std::abs(b.v[k]))) << what << ", " << k;
  }
}

class CeresCasesJet : public testing::Test {
 protected:
  const D x = Make(2.3, -2.7, 1e-3), y = Make(1.7, 0.5, 1e2), z = Make(1e-6, 1e-4, 1e-2);
  const D one = D(1.0), two = D(2.0), zero = Make(0, 2, 3.14);
};

TEST_F(CeresCasesJet, Arithmetic) {
  ExpectSameDual("product and quotient", x * y / x, y);
  ExpectSameDual("sum with a number", x + 1.0, 1.0 + x);
  ExpectSameDual("difference with a number", 1.0 - x, -(x - 1.0));
  ExpectSameDual("quotient by a number", 5.0 * (x / 5.0), x * 5.0 / 5.0);
  ExpectSameDual("quotient of quotients", x / y, 1.0 / (y / x));
  D sum = x, scaled = x;
  sum += one, sum -= 2.0, scaled *= 5.0, scaled /= 10.0;
  ExpectSameDual("+= and -=", sum, x - one);
  ExpectSameDual("*= and /=", scaled, x / two);
}

TEST_F(CeresCasesJet, Identities) {
  ExpectSameDual("log exp", log(exp(x)), x);
  ExpectSameDual("log1p expm1", log1p(expm1(x)), x);
  ExpectSameDual("expm1 log1p", expm1(log1p(x)), x);
  ExpectSameDual("root of a square", sqrt(x * x), x);
  ExpectSameDual("square of a root", sqrt(y) * sqrt(y), y);
  ExpectSameDual("cos of twice", cos(two * x), cos(x) * cos(x) - sin(x) * sin(x));
  ExpectSameDual("sin of twice", sin(two * x), two * cos(x) * sin(x));
  ExpectSameDual("cos^2 + sin^2", cos(x) * cos(x) + sin(x) * sin(x), one);
  const D angle = Make(0.7, -0.3, 1.5), radius = Make(2.3, 0.13, -2.4);
  ExpectSameDual("atan2", atan2(radius * sin(angle), radius * cos(angle)), angle);
  ExpectSameDual("tan", tan(x), sin(x) / cos(x));
  ExpectSameDual("tan atan", tan(atan(x)), x);
  ExpectSameDual("cosh^2 - sinh^2", cosh(x) * cosh(x) - sinh(x) * sinh(x), one);
  ExpectSameDual("tanh of a sum", tanh(x + y), (tanh(x) + tanh(y)) / (one + tanh(x) * tanh(y)));
  for (const D& w : {Make(0.1, -2.7, 1e-3), Make(0.6, 0.5, 1e2)}) {
    ExpectSameDual("cos acos", cos(acos(w)), w);
    ExpectSameDual("acos cos", acos(cos(w)), w);
    ExpectSameDual("sin asin", sin(asin(w)), w);
    ExpectSameDual("asin sin", asin(sin(w)), w);
  }
  ExpectSameDual("abs of a square", abs(-x * x), x * x);
  ExpectSameDual("abs", abs(-x), sqrt(x * x));
  ExpectSameDual("cbrt of a cube", cbrt(x * x * x), x);
  ExpectSameDual("cube of cbrt", cbrt(y) * cbrt(y) * cbrt(y), y);
  ExpectSameDual("cbrt as a power", cbrt(x), pow(x, 1.0 / 3));
  ExpectSameDual("log1p", log1p(x), log(one + x));
  ExpectSameDual("expm1", expm1(x), exp(x) - one);
  ExpectSameDual("exp2", exp2(x), exp(x * std::numbers::ln2));
  ExpectSameDual("log10", log10(x), log(x) / std::numbers::ln10);
  ExpectSameDual("log2", log2(x), log(x) / std::numbers::ln2);
  ExpectSameDual("norm", norm(x), x * x);
  ExpectSameDual("norm of -x", norm(-x), x * x);
  ExpectSameDual("power 1", pow(x, 1.0), x);
  ExpectSameDual("power 1 as a dual number", pow(x, one), x);
  ExpectSameDual("power of e", pow(D(std::numbers::e), log(x)), x);
  ExpectSameDual("power", pow(x, y), pow(D(std::numbers::e), y * log(x)));
  const D w = Make(0.1, -2.7, 1e-3);
  ExpectSameDual("J0 of 0", j0(D(0.0)), one);
  ExpectSameDual("J1 of 0", j1(D(0.0)), D(0.0));
  ExpectSameDual("J3 of 0", jn(3, D(0.0)), D(0.0));
  ExpectSameDual("J0 as Jn", j0(w), jn(0, w));
  ExpectSameDual("J1 as Jn", j1(w), jn(1, w));
  ExpectSameDual("recurrence of Jn", j0(w) + jn(2, w), 2.0 / w * j1(w));
}

TEST_F(CeresCasesJet, Hypotenuses) {
  ExpectSameDual("hypot", hypot(x, y), sqrt(x * x + y * y));
  ExpectSameDual("hypot of equals", hypot(x, x), std::numbers::sqrt2 * abs(x));
  ExpectSameDual("hypot of three", hypot(x, y, z), sqrt(x * x + y * y + z * z));
  ExpectSameDual("hypot of three equals", hypot(x, x, x), std::numbers::sqrt3 * abs(x));
  ExpectSameDual("hypot of hypot", hypot(x, y, z), hypot(hypot(x, y), z));
  ExpectSameDual("hypot of hypot", hypot(x, y, z), hypot(x, hypot(y, z)));
  ExpectSameDual("hypot with 0", hypot(x, zero), x);
  ExpectSameDual("hypot of 0", hypot(zero, y), y);
  ExpectSameDual("hypot with two 0", hypot(x, zero, zero), x);
  ExpectSameDual("hypot with two 0", hypot(zero, y, zero), y);
  ExpectSameDual("hypot with two 0", hypot(zero, zero, z), z);
  // Tangentially to a circle or a sphere, the derivative is 0.
  ExpectSameDual("hypot", hypot(Make(2, 1, 1), Make(2, 1, -1)), Make(std::sqrt(8.0), std::sqrt(2.0), 0));
  ExpectSameDual("hypot of three", hypot(Make(2, 1, 1), Make(2, 1, -1), Make(2, -1, 0)),
                 Make(std::sqrt(12.0), 1 / std::sqrt(3.0), 0));
  // The squares underflow or overflow.
  for (const double extreme : {std::numeric_limits<double>::min(), std::numeric_limits<double>::max()}) {
    const D w = Make(extreme, 2, 3.14);
    ExpectSameDual("hypot", hypot(w, D(0.0)), w);
    ExpectSameDual("hypot of three", hypot(w, D(0.0), D(0.0)), w);
  }
}

TEST_F(CeresCasesJet, InterpolationsAndSigns) {
  ExpectSameDual("lerp at 0", lerp(x, y, D(0.0)), x);
  ExpectSameDual("lerp at 1", lerp(x, y, one), y);
  ExpectSameDual("lerp of equals", lerp(x, x, one), x);
  ExpectSameDual("lerp in the middle", lerp(x, y, D(0.5)), (x + y) / two);
  ExpectSameDual("lerp beyond 1", lerp(x, y, two), two * y - x);
  ExpectSameDual("lerp before 0", lerp(x, y, -two), 3.0 * x - two * y);
  for (const double sign : {1.0, -1.0}) {
    ExpectSameDual("copysign", copysign(x, D(sign)), sign * x);
    ExpectSameDual("copysign of -x", copysign(-x, D(sign)), sign * x);
    ExpectSameDual("copysign by NaN", copysign(x, D(std::copysign(kNaN, sign))), sign * x);
    ExpectSameDual("copysign of 0", copysign(zero, D(sign)), sign * zero);
    EXPECT_EQ(std::signbit(copysign(zero, D(sign)).a), sign < 0);
    ExpectSameDual("copysign of -0", copysign(-zero, D(sign)), sign * zero);
  }
}

TEST_F(CeresCasesJet, DerivativesAreSlopes) {
  const auto expect = [](const char* name, const auto& f, std::initializer_list<double> points) {
    for (const double at : points) {
      const double step = 1e-8, slope = (f(D(at + step)).a - f(D(at - step)).a) / (2 * step);
      const D found = f(Make(at, 1, -2));
      EXPECT_NEAR(found.v[0], slope, 1e-6 * std::max(1.0, std::abs(slope))) << name << " at " << at;
      EXPECT_NEAR(found.v[1], -2 * found.v[0], 1e-15 * std::abs(found.v[0])) << name << " at " << at;
    }
  };
  expect("sqrt", [](const D& t) { return sqrt(t); }, {1e-5, 1});
  expect("erf", [](const D& t) { return erf(t); }, {-1, 1e-5, 0.5, 100});
  expect("erfc", [](const D& t) { return erfc(t); }, {-1, 1e-5, 0.5, 100});
  expect("cbrt", [](const D& t) { return cbrt(t); }, {-1, -1e-5, 1e-5, 1});
  expect("exp2", [](const D& t) { return exp2(t); }, {-1, -1e-5, -1e-200, 0, 1e-200, 1e-5, 1});
  expect("log10", [](const D& t) { return log10(t); }, {1e-5, 1, 98.76});
  expect("log2", [](const D& t) { return log2(t); }, {1e-5, 1, 100});
  for (const auto& [a, b] : {std::pair(0.0, 1e-5), std::pair(-1e-5, 0.0), std::pair(1e-5, 1e-5), std::pair(0.0, 1.0),
                             std::pair(1e-3, -1.0), std::pair(-1e-3, 1.0), std::pair(1.0, 2.0)}) {
    expect("hypot", [b = b](const D& t) { return hypot(t, D(b)); }, {a});
    expect("hypot", [a = a](const D& t) { return hypot(D(a), t); }, {b});
  }
}

TEST_F(CeresCasesJet, SmallNumbersKeepTheirDigits) {
  const D tiny = Make(1e-16, 1e-8, 1e-4);
  for (const D& w : {log1p(tiny), expm1(tiny)}) {
    EXPECT_DOUBLE_EQ(w.a, 1e-16);
    EXPECT_DOUBLE_EQ(w.v[0], 1e-8);
    EXPECT_DOUBLE_EQ(w.v[1], 1e-4);
  }
  EXPECT_EQ(log(D(1.0) + tiny).a, 0);
  EXPECT_EQ((exp(tiny) - D(1.0)).a, 0);
}

// Powers of 0 and of negative numbers are finite where powers of jets are finite, and then equal. The same for dual
// numbers of one derivative.
void ExpectPower(const Jet& base, const Jet& exponent) {
  const Jet expected = pow(base, exponent);
  const auto make = [](const Jet& jet) { return Make(jet.a, jet.v[0], jet.v[1]); };
  const D found = pow(make(base), make(exponent));
  const std::string where = std::to_string(base.a) + "^" + std::to_string(exponent.a);
  const auto expect = [&](double a, double b) {
    EXPECT_EQ(std::isfinite(a), std::isfinite(b)) << where << ": " << a << ", " << b;
    if (!std::isfinite(b)) return;
    EXPECT_NEAR(a, b, 1e-13 * std::max(1.0, std::abs(b))) << where;
  };
  expect(found.a, expected.a);
  for (int k = 0; k < 2; ++k) {
    expect(found.v[k], expected.v[k]);
    expect(pow(Dual<double>(base.a, base.v[k]), Dual<double>(exponent.a, exponent.v[k])).v, expected.v[k]);
  }
}

TEST_F(CeresCasesJet, PowersOfZeroAndOfNegativeNumbers) {
  const Jet nothing(0, Eigen::Vector2d(1, 2)), negative(-1.5, Eigen::Vector2d(3, 4));
  // Exponents with derivatives: 2, 1, from 0.1 to 0.9, negative, and 0.
  ExpectPower(nothing, Jet(2, Eigen::Vector2d(3, 4)));
  ExpectPower(nothing, Jet(1, Eigen::Vector2d(3, 4)));
  for (int i = -10; i < 10; ++i) ExpectPower(nothing, Jet(0.1 * i, Eigen::Vector2d(3, 4)));
  // A derivative of the exponent has no meaning at a negative base.
  for (int i = -10; i <= 10; ++i) {
    ExpectPower(negative, Jet(i, Eigen::Vector2d(0, 5)));
    ExpectPower(Jet(-1.5), Jet(i, Eigen::Vector2d(3, 0)));
  }
  ExpectPower(negative, Jet(-2.5, Eigen::Vector2d(0, 5)));
  ExpectPower(Jet(-1.5), Jet(-3.14, Eigen::Vector2d(3, 0)));
  ExpectPower(Jet(0.0), Jet(2, Eigen::Vector2d(3, 4)));
}

TEST_F(CeresCasesJet, StepsAndExtremes) {
  for (const double value : {0.1, -1.1, 10.123}) {
    const D w = Make(value, -2.7, 1e-3);
    ExpectSameDual("floor", floor(w), D(std::floor(value)));
    ExpectSameDual("ceil", ceil(w), D(std::ceil(value)));
  }
  const D far = Make(10.123, -2.7, 1e-3);
  ExpectSameDual("erf far out", erf(far), D(std::erf(10.123)));
  ExpectSameDual("erfc far out", erfc(far), D(std::erfc(10.123)));
  for (const auto& [a, b] : {std::pair(x, y), std::pair(y, x)}) {
    ExpectSameDual("fmax", fmax(a, b), x);
    ExpectSameDual("fmin", fmin(a, b), y);
  }
  ExpectSameDual("fmax with a number", fmax(y, x.a), D(x.a));
  ExpectSameDual("fmax with a number", fmax(y.a, x), x);
  ExpectSameDual("fmin with a number", fmin(x, y.a), D(y.a));
  ExpectSameDual("fmin with a number", fmin(x.a, y), y);
  for (const D& w : {fmax(x, kNaN), fmax(kNaN, x), fmin(x, kNaN), fmin(kNaN, x)}) ExpectSameDual("NaN", w, x);
}

// Derivatives that are not finite do not count.
TEST_F(CeresCasesJet, Classification) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double values[][3] = {{5.5, kNaN, kInfinity}, {5.5, kNaN, 0}, {5.5, -kInfinity, 0}, {5.5, 100, 1}, {kNaN, 1, 2},
                              {kInfinity, 1, 2},      {0, 1, 2},      {1e-310, 1, 2}};
  for (const auto& [a, first, second] : values) {
    const D ours = Make(a, first, second);
    const Jet theirs(a, Eigen::Vector2d(first, second));
    EXPECT_EQ(isfinite(ours), isfinite(theirs)) << a;
    EXPECT_EQ(isinf(ours), isinf(theirs)) << a;
    EXPECT_EQ(isnan(ours), isnan(theirs)) << a;
    EXPECT_EQ(isnormal(ours), isnormal(theirs)) << a;
  }
}

TEST_F(CeresCasesJet, InEigenMatrices) {
  Eigen::Matrix<D, 2, 2> m;
  m << x, y, Make(5.3, -4.7, 1e-3), Make(9.7, 1.5, 10.1);
  const Eigen::Matrix<D, 2, 1> v(m(0, 0), m(1, 0)), product = m * v;
  const Eigen::Matrix<D, 1, 2> transposed = v.transpose() * m.transpose();
  const Eigen::Vector2d numbers(0.6, -2.1);
  const Eigen::Matrix<D, 2, 1> mixed = m * numbers, cast = m * numbers.cast<D>();
  const Eigen::Array<D, 2, 1> array = v.array() * numbers.array();
  const Eigen::Matrix<D, 2, 2> scaled = m * 3.1;
  for (int k = 0; k < 2; ++k) {
    ExpectSameDual("product", product[k], transposed[k]);
    ExpectSameDual("row", product[k], m(k, 0) * v[0] + m(k, 1) * v[1]);
    ExpectSameDual("product with numbers", mixed[k], cast[k]);
    ExpectSameDual("product of arrays", array[k], v[k] * numbers[k]);
    ExpectSameDual("multiple", scaled(k, 1), m(k, 1) * D(3.1));
  }
  ExpectSameDual("sum", v.sum(), v[0] + v[1]);
  ExpectSameDual("sum of an array", array.sum(), array[0] + array[1]);
}

// The matrix I + t A. At t = 0, its decompositions are trivial.
TEST_F(CeresCasesJet, InEigenDecompositions) {
  Eigen::Matrix<D, 3, 3> a;
  Eigen::Matrix<D, 3, 1> b;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) a(i, j) = Make(i == j, i, j * j);
    b(i) = Make(i, i, i);
  }
  const Eigen::Matrix<D, 3, 1> by_llt = a.llt().solve(b), by_ldlt = a.ldlt().solve(b), by_lu = a.lu().solve(b);
  for (int i = 0; i < 3; ++i) {
    for (const D& found : {by_llt(i), by_ldlt(i), by_lu(i)}) EXPECT_EQ(found.a, i);
    // The derivative of A^-1 b at A = I is b' - A' b.
    D expected = b(i);
    for (int j = 0; j < 3; ++j) expected = expected - Make(0, a(i, j).v[0] * j, a(i, j).v[1] * j);
    ExpectSameDual("lu", by_lu(i), expected);
  }
}

// Third derivatives of x^3 and exp(x) at 1.
TEST_F(CeresCasesJet, Nest) {
  using First = Dual<double>;
  using Second = Dual<First>;
  using Third = Dual<Second>;
  const Second seed(First(1.0, 1.0), First(1.0));
  const Third t(seed, Second(First(1.0)));
  const Third cube = t * t * t, power = exp(t);
  EXPECT_DOUBLE_EQ(cube.a.a.a, 1);
  EXPECT_DOUBLE_EQ(cube.v.a.a, 3);
  EXPECT_DOUBLE_EQ(cube.v.v.a, 6);
  EXPECT_DOUBLE_EQ(cube.v.v.v, 6);
  for (const double value : {power.a.a.a, power.v.a.a, power.v.v.a, power.v.v.v}) EXPECT_DOUBLE_EQ(value, std::exp(1));
}

}  // namespace
}  // namespace vesta::test
