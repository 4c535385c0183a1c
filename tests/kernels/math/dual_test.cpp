#include "kernels/math/dual.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/random.h"

namespace vesta {
namespace {

using Jet = ceres::Jet<double, 1>;
using D = Dual<double>;

Jet ToJet(const D& a) {
  Jet jet(a.v);
  jet.v[0] = a.d;
  return jet;
}

void ExpectSame(const D& dual, const Jet& jet, const char* what) {
  EXPECT_NEAR(dual.v, jet.a, 1e-15 * std::abs(jet.a)) << what;
  EXPECT_NEAR(dual.d, jet.v[0], 1e-14 * (std::abs(jet.v[0]) + std::abs(jet.a))) << what;
}

TEST(Dual, EveryFunctionAgreesWithJets) {
  using std::abs, std::acos, std::asin, std::atan, std::atan2, std::cos, std::cosh, std::exp, std::hypot, std::sinh,
      std::tan, std::tanh, std::log, std::pow, std::sin, std::sqrt;
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
  }
}

TEST(Dual, AssignmentsAreTheOperators) {
  const D a(1.5, -2), b(0.7, 3);
  D sum = a, difference = a, product = a, quotient = a;
  sum += b, difference -= b, product *= b, quotient /= b;
  EXPECT_TRUE(sum == a + b && sum.d == (a + b).d);
  EXPECT_TRUE(difference == a - b && difference.d == (a - b).d);
  EXPECT_TRUE(product == a * b && product.d == (a * b).d);
  EXPECT_TRUE(quotient == a / b && quotient.d == (a / b).d);
}

TEST(Dual, ComparisonsLookAtTheValueAlone) {
  const D a(1, 5), b(2, -5), same(1, 7);
  EXPECT_TRUE(a < b && b > a && a <= same && a >= same && a == same);
  EXPECT_FALSE(b < a || a > b || a == b);
}

// A power with a constant exponent has no logarithm in its derivative: bases at and below zero stay finite.
TEST(Dual, PowerWithConstantExponentTakesAnyBase) {
  const D square_at_zero = pow(D(0.0, 1.0), D(2));
  EXPECT_EQ(square_at_zero.v, 0);
  EXPECT_EQ(square_at_zero.d, 0);
  // Nor has a base at zero under a positive exponent that varies.
  const D varying_at_zero = pow(D(0.0, 1.0), D(1.5, 1.0));
  EXPECT_EQ(varying_at_zero.v, 0);
  EXPECT_EQ(varying_at_zero.d, 0);
  const D cube = pow(D(-2.0, 1.0), D(3));
  EXPECT_EQ(cube.v, -8);
  EXPECT_EQ(cube.d, 12);
}

// Second derivatives: a dual of duals.
TEST(Dual, Nests) {
  using DD = Dual<D>;
  const double x = 0.7;
  const DD y = exp(sin(DD(D(x, 1.0), D(1.0, 0.0))));
  const double first = std::exp(std::sin(x)) * std::cos(x);
  EXPECT_NEAR(y.d.v, first, 1e-15);
  EXPECT_NEAR(y.d.d, first * std::cos(x) - std::exp(std::sin(x)) * std::sin(x), 1e-14);
}

// The value part rounds as plain arithmetic does: a cut-off cannot flip between a function and its tangent.
TEST(Dual, ValuesAreBitIdenticalToPlainArithmetic) {
  test::Random random(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const float a = static_cast<float>(random.Normal()), b = static_cast<float>(random.Normal()),
                c = static_cast<float>(random.Normal());
    const Dual<float> da(a, 1.0f), db(b, 2.0f), dc(c, 3.0f);
    EXPECT_EQ(Fma(da, db, dc).v, Fma(a, b, c));
    EXPECT_EQ((da * db + dc).v, a * b + c);
    EXPECT_EQ((da / db).v, a / b);
    EXPECT_EQ(Clamp(da, db, dc).v, Clamp(a, b, c));
  }
}

}  // namespace
}  // namespace vesta
