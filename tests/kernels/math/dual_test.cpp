// SPDX-License-Identifier: Apache-2.0
#include "kernels/math/dual.h"

#include <ceres/cubic_interpolation.h>
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/random.h"

namespace vesta {
namespace {

using Jet = ceres::Jet<double, 1>;
using D = Dual<double>;

Jet ToJet(const D& a) {
  Jet jet(a.a);
  jet.v[0] = a.v;
  return jet;
}

void ExpectSame(const D& dual, const Jet& jet, const char* what) {
  EXPECT_NEAR(dual.a, jet.a, 1e-15 * std::abs(jet.a)) << what;
  EXPECT_NEAR(dual.v, jet.v[0], 1e-14 * (std::abs(jet.v[0]) + std::abs(jet.a))) << what;
}

// For functions whose Jet formula rounds more coarsely.
void ExpectNear(const D& dual, const Jet& jet, const char* what) {
  EXPECT_NEAR(dual.a, jet.a, 1e-14 * (1 + std::abs(jet.a))) << what;
  EXPECT_NEAR(dual.v, jet.v[0], 1e-13 * (1 + std::abs(jet.v[0]))) << what;
}

TEST(Dual, EveryFunctionAgreesWithJets) {
  using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::cosh, std::exp, std::hypot, std::sinh,
      std::tan, std::tanh, std::log, std::pow, std::sin, std::sqrt;
  using std::acosh, std::asinh, std::atanh, std::cbrt, std::ceil, std::erf, std::erfc, std::exp2, std::expm1,
      std::floor, std::fmax, std::fmin, std::log10, std::log1p, std::log2;
  test::Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const D a(random.Normal(), random.Normal()), b(random.Normal(), random.Normal());
    const D positive(random.LogUniform(0.01, 10), random.Normal()), constant(random.Uniform(-3, 3));
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
    const D inside(random.Uniform(-0.95, 0.95), random.Normal());
    ExpectSame(asin(inside), asin(ToJet(inside)), "asin");
    ExpectSame(acos(inside), acos(ToJet(inside)), "acos");
    ExpectSame(hypot(a, b), hypot(ja, jb), "hypot");
    ExpectSame(atan2(a, b), atan2(ja, jb), "atan2");
    ExpectSame(abs(a), abs(ja), "abs");
    ExpectSame(pow(positive, b), pow(jp, jb), "pow");
    ExpectSame(pow(positive, constant), pow(jp, jc), "pow, constant exponent");
    ExpectSame(pow(a, D(3)), ja * ja * ja, "cube");
    ExpectSame(Fma(a, b, positive), ja * jb + jp, "fma");
    ExpectSame(Max(a, b), ja < jb ? jb : ja, "max");
    ExpectSame(Min(a, b), jb < ja ? jb : ja, "min");
    ExpectSame(Clamp(a, D(-0.5), D(0.5)), ja.a < -0.5 ? Jet(-0.5) : ja.a > 0.5 ? Jet(0.5) : ja, "clamp");
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
    // Jets lack the inverse hyperbolic functions, so the reference uses logarithms.
    ExpectNear(asinh(positive), log(jp + sqrt(jp * jp + 1.0)), "asinh");
    const D above = D(1.1) + positive * positive;
    ExpectNear(acosh(above), log(ToJet(above) + sqrt(ToJet(above) * ToJet(above) - 1.0)), "acosh");
    const Jet ji = ToJet(inside);
    ExpectNear(atanh(inside), log((1.0 + ji) / (1.0 - ji)) * 0.5, "atanh");
  }
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
  using std::isfinite, std::isinf, std::isnan, std::fmax, std::fmin;
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
  Jet jet;
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

// The derivative of a power with constant exponent contains no logarithm: it is finite for bases at and below zero.
TEST(Dual, PowerWithConstantExponentTakesAnyBase) {
  const D square_at_zero = pow(D(0.0, 1.0), D(2));
  EXPECT_EQ(square_at_zero.a, 0);
  EXPECT_EQ(square_at_zero.v, 0);
  // It is also finite for base zero and a positive exponent that varies.
  const D varying_at_zero = pow(D(0.0, 1.0), D(1.5, 1.0));
  EXPECT_EQ(varying_at_zero.a, 0);
  EXPECT_EQ(varying_at_zero.v, 0);
  const D cube = pow(D(-2.0, 1.0), D(3));
  EXPECT_EQ(cube.a, -8);
  EXPECT_EQ(cube.v, 12);
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

// Values are rounded like plain arithmetic, so a threshold cannot differ between a function and its tangent.
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
