// SPDX-License-Identifier: Apache-2.0
#include <ceres/cubic_interpolation.h>
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>
#include <type_traits>
#include <utility>

#include "kernels/math/derivatives.h"
#include "tests/support/random.h"

namespace vesta {
namespace {

using D = Dual<double>;

template <int N>
ceres::Jet<double, N> ToJet(const Dual<double, N>& x) {
  ceres::Jet<double, N> jet(x.a);
  for (int i = 0; i < N; ++i) jet.v[i] = DerivativeOf(x, i);
  return jet;
}

template <int N>
void ExpectSame(const Dual<double, N>& dual, const ceres::Jet<double, N>& jet, const char* what) {
  EXPECT_NEAR(dual.a, jet.a, 1e-15 * std::abs(jet.a)) << what;
  for (int i = 0; i < N; ++i) {
    EXPECT_NEAR(DerivativeOf(dual, i), jet.v[i], 1e-14 * (std::abs(jet.v[i]) + std::abs(jet.a))) << what;
  }
}

// The Jet formula rounds more coarsely.
template <int N>
void ExpectNear(const Dual<double, N>& dual, const ceres::Jet<double, N>& jet, const char* what) {
  EXPECT_NEAR(dual.a, jet.a, 1e-14 * (1 + std::abs(jet.a))) << what;
  for (int i = 0; i < N; ++i) {
    EXPECT_NEAR(DerivativeOf(dual, i), jet.v[i], 1e-13 * (1 + std::abs(jet.v[i]))) << what;
  }
}

template <int N>
Dual<double, N> Variable(test::Random& random, double value) {
  Dual<double, N> x(value);
  for (int i = 0; i < N; ++i) DerivativeOf(x, i) = random.Normal();
  return x;
}

template <int N>
void ExpectFunctionsOfJets() {
  using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::cosh, std::exp, std::hypot, std::sinh,
      std::tan, std::tanh, std::log, std::pow, std::sin, std::sqrt;
  using std::acosh, std::asinh, std::atanh, std::cbrt, std::ceil, std::erf, std::erfc, std::exp2, std::expm1,
      std::floor, std::fmax, std::fmin, std::log10, std::log1p, std::log2;
  using std::copysign, std::fdim, std::fma, std::lerp, std::midpoint, std::norm;
  using Number = Dual<double, N>;
  using Jet = ceres::Jet<double, N>;
  test::Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Number a = Variable<N>(random, random.Normal()), b = Variable<N>(random, random.Normal());
    const Number positive = Variable<N>(random, random.LogUniform(0.01, 10)), constant(random.Uniform(-3, 3));
    const Jet ja = ToJet(a), jb = ToJet(b), jp = ToJet(positive), jc = ToJet(constant);
    ExpectSame(-a, -ja, "negation");
    ExpectSame(a + b, ja + jb, "sum");
    ExpectSame(a - b, ja - jb, "difference");
    ExpectSame(a * b, ja * jb, "product");
    ExpectSame(a / positive, ja / jp, "quotient");
    ExpectSame(exp(a), exp(ja), "exp");
    ExpectSame(log(positive), log(jp), "log");
    ExpectSame(sqrt(positive), sqrt(jp), "sqrt");
    ExpectSame(sin(a), sin(ja), "sin");
    ExpectSame(cos(a), cos(ja), "cos");
    ExpectSame(atan(a), atan(ja), "atan");
    ExpectSame(tan(a), tan(ja), "tan");
    ExpectSame(sinh(a), sinh(ja), "sinh");
    ExpectSame(cosh(a), cosh(ja), "cosh");
    ExpectSame(tanh(a), tanh(ja), "tanh");
    const Number inside = Variable<N>(random, random.Uniform(-0.95, 0.95));
    ExpectSame(asin(inside), asin(ToJet(inside)), "asin");
    ExpectSame(acos(inside), acos(ToJet(inside)), "acos");
    ExpectSame(hypot(a, b), hypot(ja, jb), "hypot");
    ExpectSame(atan2(a, b), atan2(ja, jb), "atan2");
    ExpectSame(abs(a), abs(ja), "abs");
    ExpectSame(pow(positive, b), pow(jp, jb), "pow");
    ExpectSame(pow(positive, constant), pow(jp, jc), "pow, constant exponent");
    ExpectSame(pow(positive, constant.a), pow(jp, jc.a), "pow, number as exponent");
    ExpectSame(pow(2.5, a), pow(2.5, ja), "pow, number as base");
    ExpectSame(pow(a, Number(3)), ja * ja * ja, "cube");
    ExpectSame(Fma(a, b, positive), ja * jb + jp, "fma");
    ExpectSame(Max(a, b), ja < jb ? jb : ja, "max");
    ExpectSame(Min(a, b), jb < ja ? jb : ja, "min");
    ExpectSame(Clamp(a, Number(-0.5), Number(0.5)), ja.a < -0.5 ? Jet(-0.5) : ja.a > 0.5 ? Jet(0.5) : ja, "clamp");
    ExpectSame(Select(a > b, a, b), ja > jb ? ja : jb, "select");
    ExpectSame(Square(a), ja * ja, "square");
    ExpectSame(+a, ja, "unary plus");
    ExpectSame(log1p(positive), log1p(jp), "log1p");
    ExpectSame(expm1(a), expm1(ja), "expm1");
    ExpectSame(log2(positive), log2(jp), "log2");
    ExpectSame(log10(positive), log10(jp), "log10");
    ExpectSame(exp2(a), exp2(ja), "exp2");
    ExpectSame(cbrt(a), cbrt(ja), "cbrt");
    ExpectSame(erf(a), erf(ja), "erf");
    ExpectSame(erfc(a), erfc(ja), "erfc");
    ExpectSame(floor(a), floor(ja), "floor");
    ExpectSame(ceil(a), ceil(ja), "ceil");
    ExpectSame(fmin(a, b), fmin(ja, jb), "fmin");
    ExpectSame(fmax(a, b), fmax(ja, jb), "fmax");
    ExpectSame(hypot(a, b, positive), hypot(ja, jb, jp), "hypot of three");
    ExpectSame(fma(a, b, positive), fma(ja, jb, jp), "std::fma");
    ExpectSame(copysign(a, b), copysign(ja, jb), "copysign");
    ExpectSame(fdim(a, b), fdim(ja, jb), "fdim");
    ExpectSame(norm(a), norm(ja), "norm");
    ExpectSame(midpoint(a, b), midpoint(ja, jb), "midpoint");
    ExpectSame(lerp(a, b, positive), lerp(ja, jb, jp), "lerp");
    ExpectSame(j0(a), BesselJ0(ja), "j0");
    ExpectSame(j1(a), BesselJ1(ja), "j1");
    ExpectSame(jn(3, a), BesselJn(3, ja), "jn");
    ExpectNear(cyl_bessel_j(3, positive), BesselJn(3, jp), "cyl_bessel_j");
    // Numbers in the place of dual numbers.
    ExpectSame(2.5 + a, 2.5 + ja, "number + dual");
    ExpectSame(a + 2, ja + 2.0, "dual + number");
    ExpectSame(2.5 - a, 2.5 - ja, "number - dual");
    ExpectSame(a - 2, ja - 2.0, "dual - number");
    ExpectSame(3 * a, 3.0 * ja, "number * dual");
    ExpectSame(a * 2.5, ja * 2.5, "dual * number");
    ExpectSame(3 / positive, 3.0 / jp, "number / dual");
    ExpectSame(a / 2.5, ja / 2.5, "dual / number");
    // Jets lack the inverse hyperbolic functions; the reference uses logarithms.
    ExpectNear(asinh(positive), log(jp + sqrt(jp * jp + 1.0)), "asinh");
    const Number above = Number(1.1) + positive * positive;
    ExpectNear(acosh(above), log(ToJet(above) + sqrt(ToJet(above) * ToJet(above) - 1.0)), "acosh");
    const Jet ji = ToJet(inside);
    ExpectNear(atanh(inside), log((1.0 + ji) / (1.0 - ji)) * 0.5, "atanh");
  }
}

// One derivative, a part of a SIMD register, several, and more than the processor has.
TEST(Dual, EveryFunctionAgreesWithJets) {
  ExpectFunctionsOfJets<1>();
  ExpectFunctionsOfJets<2>();
  ExpectFunctionsOfJets<5>();
  ExpectFunctionsOfJets<40>();
}

TEST(Dual, AssignmentsAreTheOperators) {
  const D a(1.5, -2), b(0.7, 3);
  D sum = a, difference = a, product = a, quotient = a;
  sum += b, difference -= b, product *= b, quotient /= b;
  EXPECT_TRUE(sum == a + b && sum.v == (a + b).v);
  EXPECT_TRUE(difference == a - b && difference.v == (a - b).v);
  EXPECT_TRUE(product == a * b && product.v == (a * b).v);
  EXPECT_TRUE(quotient == a / b && quotient.v == (a / b).v);
}

TEST(Dual, ComparisonsUseOnlyTheValue) {
  const D a(1, 5), b(2, -5), same(1, 7);
  EXPECT_TRUE(a < b && b > a && a <= same && a >= same && a == same);
  EXPECT_FALSE(b < a || a > b || a == b);
}

TEST(Dual, ClassificationUsesOnlyTheValue) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity(), kNan = std::numeric_limits<double>::quiet_NaN();
  using std::fpclassify, std::isgreater, std::isgreaterequal, std::isless, std::islessequal, std::islessgreater,
      std::isnormal, std::isunordered, std::signbit;
  using std::isfinite, std::isinf, std::isnan, std::fmax, std::fmin;
  EXPECT_TRUE(isnormal(D(1, kNan)) && !isnormal(D(1e-310, 1)));
  EXPECT_TRUE(signbit(D(-0.0, 1)) && !signbit(D(0.0, -1)));
  EXPECT_TRUE(fpclassify(D(kInfinity, 1)) == FP_INFINITE && fpclassify(D(0.0, kNan)) == FP_ZERO);
  const D one(1, 5), two(2, -5), none(kNan);
  EXPECT_TRUE(isless(one, two) && !isless(two, one) && !isless(one, none));
  EXPECT_TRUE(islessequal(one, one) && !islessequal(two, one) && !islessequal(one, none));
  EXPECT_TRUE(isgreater(two, one) && !isgreater(one, two) && !isgreater(one, none));
  EXPECT_TRUE(isgreaterequal(one, one) && !isgreaterequal(one, two) && !isgreaterequal(one, none));
  EXPECT_TRUE(islessgreater(one, 2.0) && !islessgreater(one, 1.0) && !islessgreater(one, none));
  EXPECT_TRUE(isunordered(one, none) && !isunordered(one, two));
  EXPECT_TRUE(isfinite(D(1, kNan)) && !isfinite(D(kNan, 1)) && !isfinite(D(kInfinity, 1)));
  EXPECT_TRUE(isnan(D(kNan, 1)) && !isnan(D(1, kNan)));
  EXPECT_TRUE(isinf(D(-kInfinity, 1)) && !isinf(D(1, kInfinity)));
  for (const auto& [a, b] : {std::pair(D(kNan, 1), D(2, 3)), std::pair(D(2, 3), D(kNan, 1))}) {
    EXPECT_TRUE(fmax(a, b).a == 2 && fmax(a, b).v == 3);
    EXPECT_TRUE(fmin(a, b).a == 2 && fmin(a, b).v == 3);
  }
}

// Ceres's templates access members of a Jet by name.
TEST(Dual, CeresInterpolatesOnIt) {
  const double values[] = {1, 2, 5, 6, 3};
  const ceres::Grid1D<double> line(values, 0, 5);
  const ceres::CubicInterpolator<ceres::Grid1D<double>> curve(line);
  D dual;
  ceres::Jet<double, 1> jet;
  curve.Evaluate(D(1.3, 2.0), &dual);
  curve.Evaluate(ToJet(D(1.3, 2.0)), &jet);
  ExpectSame(dual, jet, "cubic");
  const double square[] = {1, 2, 5, 6, 3, 2, 4, 8, 1, 7, 3, 2, 6, 5, 9, 1};
  const ceres::Grid2D<double> plane(square, 0, 4, 0, 4);
  const ceres::BiCubicInterpolator<ceres::Grid2D<double>> surface(plane);
  surface.Evaluate(D(1.3, 2.0), D(1.9, -1.0), &dual);
  surface.Evaluate(ToJet(D(1.3, 2.0)), ToJet(D(1.9, -1.0)), &jet);
  ExpectSame(dual, jet, "bicubic");
}

// A power with constant exponent has no logarithm in its derivative, which is finite for bases at and below zero,
TEST(Dual, PowerWithConstantExponentTakesAnyBase) {
  const D square_at_zero = pow(D(0.0, 1.0), D(2));
  EXPECT_EQ(square_at_zero.a, 0);
  EXPECT_EQ(square_at_zero.v, 0);
  // and for base zero with a varying positive exponent.
  const D varying_at_zero = pow(D(0.0, 1.0), D(1.5, 1.0));
  EXPECT_EQ(varying_at_zero.a, 0);
  EXPECT_EQ(varying_at_zero.v, 0);
  const D cube = pow(D(-2.0, 1.0), D(3));
  EXPECT_EQ(cube.a, -8);
  EXPECT_EQ(cube.v, 12);
}

// With many derivatives, the exponent can be constant in only some of the directions.
TEST(Dual, PowerTakesAnyBaseInDirectionsOfConstantExponent) {
  Dual<double, 3> x(-2.0), y(3.0);
  x.v[0] = 1;
  y.v[2] = 1;
  const auto cube = pow(x, y);
  EXPECT_EQ(cube.a, -8);
  EXPECT_EQ(cube.v[0], 12);
  EXPECT_EQ(cube.v[1], 0);
  EXPECT_TRUE(std::isnan(cube.v[2]));
}

TEST(Dual, ValuesAtTheEdges) {
  using std::abs, std::hypot;
  EXPECT_FALSE(std::signbit(abs(D(-0.0, 3.0)).a));
  EXPECT_EQ(abs(D(-0.0, 3.0)).v, -3);
  EXPECT_EQ(abs(D(0.0, 3.0)).v, 3);
  const D h = hypot(D(3e307, 1.0), D(4e307, 2.0)), h3 = hypot(D(2e307, 1.0), D(3e307, 2.0), D(6e307, 3.0));
  EXPECT_DOUBLE_EQ(h.a, 5e307);
  EXPECT_DOUBLE_EQ(h.v, 0.6 + 2 * 0.8);
  EXPECT_DOUBLE_EQ(h3.a, 7e307);
  EXPECT_DOUBLE_EQ(h3.v, (2 + 2 * 3 + 3 * 6) / 7.0);
}

// Orders below 1 have their own formula: cyl_bessel_j(1/2, x) is sqrt(2 / (pi x)) sin x.
TEST(Dual, BesselFunctionsOfFractionalOrder) {
  const double x = 1.3, factor = std::sqrt(2 / (std::numbers::pi * x));
  const D half = cyl_bessel_j(0.5, D(x, 1.0)), zero = cyl_bessel_j(0, D(x, 1.0));
  EXPECT_NEAR(half.a, factor * std::sin(x), 1e-14);
  EXPECT_NEAR(half.v, factor * (std::cos(x) - std::sin(x) / (2 * x)), 1e-14);
  EXPECT_NEAR(zero.v, -j1(x), 1e-14);
  using F = Dual<float>;
  const auto single = static_cast<float>(x);
  EXPECT_NEAR(cyl_bessel_j(0.5, F(single, 1.0f)).v, half.v, 1e-6);
  EXPECT_NEAR(j0(F(single, 1.0f)).v, zero.v, 1e-6);
}

TEST(Dual, PrintsValueAndDerivatives) {
  std::ostringstream one, three;
  Dual<double, 3> x(1.5);
  x.v[1] = -2;
  one << D(1.5, -2.0);
  three << x;
  EXPECT_EQ(one.str(), "[1.5; -2]");
  EXPECT_EQ(three.str(), "[1.5; 0, -2, 0]");
}

TEST(Dual, HasTheLimitsOfItsScalar) {
  using Limits = std::numeric_limits<Dual<float, 6>>;
  using Scalar = std::numeric_limits<float>;
  static_assert(Limits::is_specialized && Limits::digits == Scalar::digits && !Limits::is_integer);
  EXPECT_EQ(Limits::epsilon().a, Scalar::epsilon());
  EXPECT_EQ(Limits::epsilon().v[5], 0);
  EXPECT_EQ(Limits::max().a, Scalar::max());
  EXPECT_EQ(Limits::lowest().a, Scalar::lowest());
  EXPECT_EQ(Limits::min().a, Scalar::min());
  EXPECT_EQ(Limits::infinity().a, Scalar::infinity());
  EXPECT_TRUE(std::isnan(Limits::quiet_NaN().a));
  static_assert(std::numeric_limits<D>::max().a == std::numeric_limits<double>::max());
}

// Second derivatives: a dual of duals.
TEST(Dual, Nests) {
  using DD = Dual<D>;
  const double x = 0.7;
  const DD y = exp(sin(DD(D(x, 1.0), D(1.0, 0.0))));
  const double first = std::exp(std::sin(x)) * std::cos(x);
  EXPECT_NEAR(y.v.a, first, 1e-15);
  EXPECT_NEAR(y.v.v, first * std::cos(x) - std::exp(std::sin(x)) * std::sin(x), 1e-14);
}

// Values round like plain arithmetic, so thresholds cannot differ between a function and its tangent.
TEST(Dual, ValuesAreBitIdenticalToPlainArithmetic) {
  test::Random random(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const float a = static_cast<float>(random.Normal()), b = static_cast<float>(random.Normal()),
                c = static_cast<float>(random.Normal());
    const Dual<float> da(a, 1.0f), db(b, 2.0f), dc(c, 3.0f);
    EXPECT_EQ(Fma(da, db, dc).a, Fma(a, b, c));
    EXPECT_EQ((da * db + dc).a, a * b + c);
    EXPECT_EQ((da / db).a, a / b);
    EXPECT_EQ(Clamp(da, db, dc).a, Clamp(a, b, c));
  }
}

}  // namespace
}  // namespace vesta
