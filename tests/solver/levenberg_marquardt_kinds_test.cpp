// SPDX-License-Identifier: Apache-2.0
// Levenberg-Marquardt on problems of every kind: empty, already solved, on a manifold, in float, on many threads.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "problems/toy/toy_problems.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"
#include "tests/solver/dense_operator.h"
#include "tests/solver/tight_options.h"
#include "tests/support/any_threads.h"

namespace vesta {
namespace {

TEST(LmKinds, AnEmptyProblemIsSolved) {
  Cpu backend;
  ResidualBlocks<Rosenbrock, Cpu> nothing(0, {});
  Cpu::Vector none;
  EXPECT_TRUE(IsConverged(SolveLm(LmOptions(), backend, nothing, none.view()).status));
  // Parameters without residuals: every column is zero.
  ResidualBlocks<Rosenbrock, Cpu> free(3, {});
  Cpu::Vector x = Vector({1, 2, 3});
  const LmSummary summary = SolveLm(LmOptions(), backend, free, x.view());
  EXPECT_EQ(summary.status, LmStatus::kGradientTolerance);
  EXPECT_EQ(summary.num_zero_columns, 3);
  EXPECT_EQ(x[1], 2);
}

TEST(LmKinds, ParametersNobodyReadsStay) {
  Cpu backend;
  ResidualBlocks<Rosenbrock, Cpu> problem(4, std::vector<Rosenbrock>(1), {1, 3});
  Cpu::Vector x = Vector({5, -1.2, 6, 1});
  const LmSummary summary = SolveLm(Tight(), backend, problem, x.view());
  EXPECT_EQ(summary.num_zero_columns, 2);
  EXPECT_EQ(x[0], 5);
  EXPECT_EQ(x[2], 6);
  EXPECT_NEAR(x[1], 1, 1e-9);
}

// A point on the unit circle: two numbers, moved by one angle.
class Circle final : public Problem<Cpu>, public OnManifold<Cpu> {
 public:
  Index num_parameters() const override { return 2; }
  Index num_tangent() const override { return 1; }
  double Cost(Cpu::ConstVectorView x) override { return 0.5 * Square(x[0] - 3) + 0.5 * Square(x[1] - 4); }
  std::unique_ptr<Linearization<Cpu>> Linearize(Cpu::ConstVectorView x) override { return std::make_unique<At>(x); }
  void Plus(Cpu&, Cpu::ConstVectorView x, Cpu::ConstVectorView delta, Cpu::VectorView out) override {
    const double c = std::cos(delta[0]), s = std::sin(delta[0]);
    out[0] = c * x[0] - s * x[1];
    out[1] = s * x[0] + c * x[1];
  }

 private:
  static double Square(double v) { return v * v; }
  class At final : public Linearization<Cpu> {
   public:
    explicit At(Cpu::ConstVectorView x) : residuals_(2), tangent_{-x[1], x[0]} {
      residuals_[0] = x[0] - 3;
      residuals_[1] = x[1] - 4;
    }
    Index num_residuals() const override { return 2; }
    Index num_parameters() const override { return 1; }
    Cpu::ConstVectorView residuals() const override { return residuals_.view(); }
    void ApplyJ(Cpu::ConstVectorView v, Cpu::VectorView u) override {
      for (int i = 0; i < 2; ++i) u[i] = tangent_[i] * v[0];
    }
    void ApplyJT(Cpu::ConstVectorView u, Cpu::VectorView g) override { g[0] = tangent_[0] * u[0] + tangent_[1] * u[1]; }
    void DiagJTJ(Cpu::VectorView d) override { d[0] = Square(tangent_[0]) + Square(tangent_[1]); }

   private:
    Cpu::Vector residuals_;
    double tangent_[2];
  };
};

TEST(LmKinds, StepsFollowAManifold) {
  Cpu backend;
  Circle circle;
  Cpu::Vector x = Vector({1, 0});
  LmOptions options = Tight();
  options.gradient_tolerance = 1e-9;
  const LmSummary summary = SolveLm(options, backend, circle, x.view());
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_NEAR(x[0], 0.6, 1e-8);
  EXPECT_NEAR(x[1], 0.8, 1e-8);
  EXPECT_EQ(summary.num_tangent, 1);
}

TEST(LmFloat, FloatReachesWhatFloatCan) {
  using B = CpuBackend<float>;
  ResidualBlocks<ExponentialFit, B> problem(2, ExponentialSamples(100));
  ResidualBlocks<ExponentialFit, Cpu> reference(2, ExponentialSamples(100));
  B backend;
  Cpu backend_double;
  B::Vector x(2);
  Cpu::Vector y(2);
  LmOptions options = Tight();
  options.function_tolerance = 1e-7;
  const LmSummary summary = SolveLm(options, backend, problem, x.view());
  SolveLm(Tight(), backend_double, reference, y.view());
  EXPECT_TRUE(IsConverged(summary.status));
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(x[k], y[k], 1e-4);
}

TEST(LmThreads, BitsDoNotDependOnThreads) {
  // Long enough for many chunks in every loop.
  constexpr Index kSize = 30000;
  const std::vector<Rosenbrock> links(kSize - 1);
  ResidualBlocks<Rosenbrock, Cpu> problem(kSize, links, RosenbrockChain(kSize));
  Cpu backend;
  LmOptions options;
  options.max_iterations = 5;
  test::ExpectSameForAnyThreads([&] {
    Cpu::Vector x(kSize);
    for (Index i = 0; i < kSize; ++i) x[i] = std::sin(static_cast<double>(i));
    const double cost = SolveLm(options, backend, problem, x.view()).final_cost;
    return std::pair(cost, std::vector<double>(x.begin(), x.end()));
  });
}

}  // namespace
}  // namespace vesta
