// SPDX-License-Identifier: Apache-2.0
// Cost functions other than AutoDiffCost: numeric differences and a prior.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "kernels/core/check.h"
#include "solver/block_problem.h"
#include "solver/cost_function.h"
#include "solver/levenberg_marquardt.h"

namespace vesta {
namespace {

struct Curves {
  template <class T>
  bool operator()(const T* p, const T* q, T* r) const {
    using std::exp;
    using std::sin;
    r[0] = exp(p[0] * q[0]) + p[1];
    r[1] = sin(p[1] * T(3.0)) - q[0] * q[0];
    r[2] = T(1e3) * p[0] * q[0];
    return p[0] > T(-1.0);
  }
};

struct Evaluation {
  double r[3] = {}, by_p[6] = {}, by_q[3] = {};
  bool ok = false;
  Evaluation(const CostFunction& cost, double p0, double p1, double q0, bool want_p = true) {
    const double p[2] = {p0, p1}, q[1] = {q0};
    const double* blocks[] = {p, q};
    double* jacobians[] = {want_p ? by_p : nullptr, by_q};
    ok = cost.Evaluate(blocks, r, jacobians);
  }
};

TEST(NumericDiffCost, AgreesWithDualNumbersToItsDigits) {
  const AutoDiffCost<Curves, 3, 2, 1> exact;
  const Evaluation expected(exact, 0.7, -0.4, 1.3);
  for (const auto& [method, digits] :
       {std::pair(DifferenceMethod::kForward, 1e-5), std::pair(DifferenceMethod::kCentral, 1e-9),
        std::pair(DifferenceMethod::kRidders, 1e-12)}) {
    const NumericDiffCost<Curves, 3, 2, 1> numeric(Curves{}, {.method = method});
    const Evaluation found(numeric, 0.7, -0.4, 1.3);
    ASSERT_TRUE(found.ok);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(found.r[i], expected.r[i]);
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(found.by_p[i], expected.by_p[i], digits * (1 + std::abs(expected.by_p[i])));
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(found.by_q[i], expected.by_q[i], digits * (1 + std::abs(expected.by_q[i])));
    // At zero, numeric differences use the smallest step. A block whose Jacobian is not requested is not written.
    const Evaluation at_zero(numeric, 0, 0, 0, false);
    for (const double entry : at_zero.by_p) EXPECT_EQ(entry, 0);
    EXPECT_NEAR(at_zero.by_q[1], 0, 1e-7);
    EXPECT_FALSE(Evaluation(numeric, -2, 0, 0).ok) << "the functor has no value there";
  }
  using Cost = NumericDiffCost<Curves, 3, 2, 1>;
  EXPECT_THROW(Cost(Curves{}, {.relative_step = 0}), Error);
  EXPECT_THROW(Cost(Curves{}, {.ridders_step = 0}), Error);
}

// The functor is undefined from p0 = -1 on, so the first steps from -0.999 lead to points without a value.
TEST(NumericDiffCost, RiddersShortensStepsToUndefinedPoints) {
  const Evaluation expected(AutoDiffCost<Curves, 3, 2, 1>(), -0.999, -0.4, 1.3);
  const NumericDiffCost<Curves, 3, 2, 1> numeric(Curves{}, {.method = DifferenceMethod::kRidders});
  const Evaluation found(numeric, -0.999, -0.4, 1.3);
  ASSERT_TRUE(found.ok);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(found.by_p[i], expected.by_p[i], 1e-9 * (1 + std::abs(expected.by_p[i])));
  EXPECT_FALSE(Evaluation(numeric, std::nextafter(-1.0, 0.0), 0, 0).ok) << "no step leads to points with values";
}

// Sizes are set at run time.
class Sum final : public NumericDifferences {
 public:
  explicit Sum(int size) : NumericDifferences(1, {size}) {}

 protected:
  bool Residuals(const double* const* p, double* r) const override {
    r[0] = -3;
    for (int i = 0; i < block_sizes()[0]; ++i) r[0] += (i + 1) * p[0][i];
    return true;
  }
};

TEST(NormalPrior, PullsWhereTheDataSaysNothing) {
  BlockProblem problem;
  const int block = problem.AddParameterBlock(3);
  problem.AddResidualBlock(std::make_shared<Sum>(3), nullptr, {block});
  const double weight = 0.1;
  problem.AddResidualBlock(std::make_shared<NormalPrior>(std::vector<double>{weight, 0, 0, 0, weight, 0, 0, 0, weight},
                                                         std::vector<double>{1, 1, 1}),
                           nullptr, {block});
  CpuBackend<double> backend;
  CpuBackend<double>::Vector x(3);
  LmOptions options;
  options.function_tolerance = 1e-16;
  const LmSummary summary = SolveLm<CpuBackend<double>>(options, backend, problem, x.view());
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  // The solution moves from (1, 1, 1) along the normal of x + 2 y + 3 z = 3, almost to that plane.
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(x[i], 1 - 3 / (14 + weight * weight) * (i + 1), 1e-7);
}

TEST(NormalPrior, EvaluatesItsMatrix) {
  const NormalPrior prior({1, 2, 3, 4, 5, 6}, {1, -1});
  EXPECT_EQ(prior.num_residuals(), 3);
  const double x[2] = {2, 1};
  const double* blocks[] = {x};
  double r[3], j[6], *jacobians[] = {j};
  ASSERT_TRUE(prior.Evaluate(blocks, r, jacobians));
  EXPECT_EQ(r[0], 5);
  EXPECT_EQ(r[2], 17);
  EXPECT_EQ(j[3], 4);
  EXPECT_THROW(NormalPrior({1, 2, 3}, {1, 2}), Error);
}

}  // namespace
}  // namespace vesta
