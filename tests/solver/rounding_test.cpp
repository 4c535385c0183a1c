// SPDX-License-Identifier: Apache-2.0
// Accuracy of the solution where the cost itself is limited by rounding.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "solver/bounds.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"
#include "tests/solver/dense_operator.h"

namespace vesta {
namespace {

// At the minimum the cost is 5. Moving x by 1e-8 changes only its last digit, so the rest of the accuracy comes from
// the gradient.
struct FarFit {
  static constexpr int kResiduals = 1, kParameters = 1;
  double t, y;
  template <class T>
  void operator()(const T* x, T* r) const {
    using std::exp;
    r[0] = exp(x[0] * T(t)) - T(y);
  }
};

TEST(Rounding, TheGradientGivesTheDigitsThatTheCostCannot) {
  std::vector<FarFit> functors;
  functors.reserve(10);
  for (int i = 0; i < 10; ++i) functors.push_back({0.1 * i, i % 2 == 0 ? 2.0 : 0.0});
  // The root of the gradient, by bisection in long double.
  const auto slope = [&](long double x) {
    long double sum = 0;
    for (const FarFit& f : functors) {
      const long double e = std::exp(x * f.t);
      sum += (e - f.y) * e * f.t;
    }
    return sum;
  };
  long double low = -3, high = 3;
  for (int k = 0; k < 100; ++k) ((slope((low + high) / 2) < 0) ? low : high) = (low + high) / 2;
  ResidualBlocks<FarFit, Cpu> problem(1, functors);
  Cpu backend;
  LmOptions options;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 0;
  for (const double start : {-1.0, 0.5, 1.7}) {
    Cpu::Vector x = Vector({start});
    const LmSummary summary = SolveLm<Cpu>(options, backend, problem, x.view());
    EXPECT_NEAR(x[0], static_cast<double>(low), 1e-14) << summary.FullReport();
    EXPECT_TRUE(IsConverged(summary.status));
    EXPECT_LT(summary.iterations.size(), 40U);
  }
}

// The same with a slope parameter at an active bound: without the bound the fit would exceed it.
struct HeldFit {
  static constexpr int kResiduals = 1, kParameters = 2;
  double t, y;
  template <class T>
  void operator()(const T* x, T* r) const {
    using std::exp;
    r[0] = exp(x[0] * T(t)) + x[1] * T(t) - T(y);
  }
};

TEST(Rounding, TheGradientDecidesWithBoundsToo) {
  constexpr double kHeld = 0.25, kFar = 100;
  std::vector<HeldFit> functors;
  functors.reserve(10);
  for (int i = 0; i < 10; ++i) functors.push_back({0.1 * i, i % 2 == 0 ? 2.0 : 0.0});
  const auto slope = [&](long double x, int by) {
    long double sum = 0;
    for (const HeldFit& f : functors) {
      const long double e = std::exp(x * f.t);
      sum += (e + kHeld * f.t - f.y) * (by == 0 ? e * f.t : f.t);
    }
    return sum;
  };
  long double low = -3, high = 3;
  for (int k = 0; k < 100; ++k) ((slope((low + high) / 2, 0) < 0) ? low : high) = (low + high) / 2;
  // At the best x_0, the cost pulls x_1 towards one side; the bound is placed on that side.
  const bool pulled_up = slope(low, 1) < 0;
  ResidualBlocks<HeldFit, Cpu> inner(2, functors);
  BoundedProblem<Cpu> problem(inner, {-kFar, pulled_up ? -kFar : kHeld}, {kFar, pulled_up ? kHeld : kFar});
  Cpu backend;
  LmOptions options;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 0;
  for (const double start : {-1.0, 0.5, 1.7}) {
    Cpu::Vector x = Vector({start, kHeld});
    const LmSummary summary = SolveLm<Cpu>(options, backend, problem, x.view());
    EXPECT_EQ(x[1], kHeld);
    EXPECT_NEAR(x[0], static_cast<double>(low), 1e-14) << summary.FullReport();
    EXPECT_TRUE(IsConverged(summary.status)) << summary.message;
    int rejected_near = 0;
    for (const LmIteration& row : summary.iterations) {
      if (row.iteration > 0 && !row.accepted && row.gradient_max_norm < 1e-6) ++rejected_near;
    }
    EXPECT_LE(rejected_near, 2) << summary.FullReport();
    EXPECT_LE(summary.iterations.back().lambda, 1) << summary.FullReport();
  }
}

}  // namespace
}  // namespace vesta
