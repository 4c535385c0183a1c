// SPDX-License-Identifier: Apache-2.0
#include "kernels/math/double_lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "kernels/core/random.h"

namespace vesta {
namespace {

using V = DoubleLanes;
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Lane i has the value first + i * step.
V Ramp(double first, double step) {
  V x;
  for (int i = 0; i < V::kWidth; ++i) x[i] = first + i * step;
  return x;
}

TEST(DoubleLanes, ExponentialIsAccurateToOneUnitInTheLastPlace) {
  CounterRandom random(1, 0);
  double worst = 0;
  for (int i = 0; i < 20000; ++i) {
    const V x = Ramp(1416 * random.Uniform() - 707, 0.37 * random.Uniform());
    const V result = exp(x);
    for (int lane = 0; lane < V::kWidth; ++lane) {
      const long double exact = std::exp(static_cast<long double>(x[lane]));
      const double unit = std::nextafter(static_cast<double>(exact), kInf) - static_cast<double>(exact);
      worst = std::max(worst, static_cast<double>(std::abs(result[lane] - exact)) / unit);
    }
  }
  EXPECT_LT(worst, 1.0);
}

TEST(DoubleLanes, ExponentialOfSpecialValues) {
  const auto at = [](double x) { return exp(V(x))[V::kWidth - 1]; };
  EXPECT_EQ(at(0), 1);
  EXPECT_EQ(at(-0.0), 1);
  EXPECT_EQ(at(kInf), kInf);
  EXPECT_EQ(at(710), kInf);
  EXPECT_TRUE(std::isfinite(at(709.78)));
  EXPECT_EQ(at(-kInf), 0);
  EXPECT_EQ(at(-750), 0);
  EXPECT_TRUE(std::isnan(at(kNaN)));
}

TEST(DoubleLanes, FunctionsWorkLaneByLane) {
  struct Function {
    std::function<V(const V&)> lanes;
    double (*number)(double);
  };
  const Function functions[] = {
      {[](const V& x) { return sqrt(x); }, std::sqrt},
      {[](const V& x) { return log(x); }, std::log},
      {[](const V& x) { return log2(x); }, std::log2},
      {[](const V& x) { return log10(x); }, std::log10},
      {[](const V& x) { return log1p(x); }, std::log1p},
      {[](const V& x) { return exp2(x); }, std::exp2},
      {[](const V& x) { return expm1(x); }, std::expm1},
      {[](const V& x) { return sin(x); }, std::sin},
      {[](const V& x) { return cos(x); }, std::cos},
      {[](const V& x) { return tan(x); }, std::tan},
      {[](const V& x) { return asin(x); }, std::asin},
      {[](const V& x) { return acos(x); }, std::acos},
      {[](const V& x) { return atan(x); }, std::atan},
      {[](const V& x) { return sinh(x); }, std::sinh},
      {[](const V& x) { return cosh(x); }, std::cosh},
      {[](const V& x) { return tanh(x); }, std::tanh},
      {[](const V& x) { return asinh(x); }, std::asinh},
      {[](const V& x) { return acosh(x + 1.0); }, [](double x) { return std::acosh(x + 1); }},
      {[](const V& x) { return atanh(x); }, std::atanh},
      {[](const V& x) { return cbrt(x); }, std::cbrt},
      {[](const V& x) { return erf(x); }, std::erf},
      {[](const V& x) { return erfc(x); }, std::erfc},
      {[](const V& x) { return floor(x * 5.0); }, [](double x) { return std::floor(x * 5); }},
      {[](const V& x) { return ceil(x * 5.0); }, [](double x) { return std::ceil(x * 5); }},
      {[](const V& x) { return abs(0.4 - x); }, [](double x) { return std::abs(0.4 - x); }},
      {[](const V& x) { return copysign(x, x - 0.4); }, [](double x) { return std::copysign(x, x - 0.4); }},
      {[](const V& x) { return fmax(x, V(0.4)); }, [](double x) { return std::fmax(x, 0.4); }},
      {[](const V& x) { return fmin(x, V(0.4)); }, [](double x) { return std::fmin(x, 0.4); }},
      {[](const V& x) { return pow(x, V(1.7)); }, [](double x) { return std::pow(x, 1.7); }},
      {[](const V& x) { return atan2(x, V(0.3)); }, [](double x) { return std::atan2(x, 0.3); }},
      {[](const V& x) { return hypot(x, V(0.3)); }, [](double x) { return std::hypot(x, 0.3); }}};
  const V x = Ramp(0.21, 0.09);
  int index = 0;
  for (const Function& function : functions) {
    const V result = function.lanes(x);
    for (int i = 0; i < V::kWidth; ++i) EXPECT_EQ(result[i], function.number(x[i])) << "function " << index;
    ++index;
  }
}

TEST(DoubleLanes, ComparisonsSelectLanes) {
  V x = Ramp(-1, 1);  // -1, 0, ...
  x[0] = kNaN;
  const V chosen = Select(x > V(0.5), V(7), V(3));
  for (int i = 0; i < V::kWidth; ++i) EXPECT_EQ(chosen[i], x[i] > 0.5 ? 7 : 3);
  EXPECT_TRUE(isnan(x)[0]);
  EXPECT_FALSE(isfinite(x)[0]);
  EXPECT_FALSE(isinf(x)[0]);
  EXPECT_TRUE((isfinite(x) && x == V(0.0))[1]);
  EXPECT_FALSE((!isfinite(x) || x != V(0.0))[1]);
  EXPECT_EQ(fmax(x, V(2))[0], 2) << "not the NaN";
  EXPECT_EQ(fmin(V(2), x)[0], 2);
}

// A function of two variables that uses most operators.
template <class T>
T Mixed(const T* p) {
  using std::abs, std::atan2, std::exp, std::hypot, std::log, std::pow, std::sin, std::sqrt;
  T sum = exp(-p[0] * T(0.3)) / (p[1] + T(2.0)) + sqrt(p[0] * p[1]) - log(p[1]) * sin(p[0]);
  sum += pow(p[0], p[1]) + pow(p[1], T(2.5)) + atan2(p[0], p[1]) + hypot(p[0], p[1]) + abs(p[0] - p[1]);
  sum -= Select(p[0] > p[1], p[0] * p[0], p[1]);
  return sum;
}

TEST(DoubleLanes, DerivativesAreThoseOfEachLane) {
  using Wide = Dual<V, 2>;
  using Narrow = Dual<double, 2>;
  const V a = Ramp(0.4, 0.3), b = Ramp(0.9, -0.05);
  Wide p[2] = {Wide(a), Wide(b)};
  for (int i = 0; i < 2; ++i) DerivativeOf(p[i], i) = V(1);
  const Wide result = Mixed(p);
  for (int lane = 0; lane < V::kWidth; ++lane) {
    Narrow q[2] = {Narrow(a[lane]), Narrow(b[lane])};
    for (int i = 0; i < 2; ++i) DerivativeOf(q[i], i) = 1;
    const Narrow expected = Mixed(q);
    EXPECT_NEAR(result.a[lane], expected.a, 1e-14);
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(DerivativeOf(result, i)[lane], DerivativeOf(expected, i), 1e-13) << i;
  }
}

}  // namespace
}  // namespace vesta
