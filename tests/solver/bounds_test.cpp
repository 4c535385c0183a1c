// SPDX-License-Identifier: Apache-2.0
#include "solver/bounds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kernels/core/check.h"
#include "problems/toy/toy_problems.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"
#include "tests/solver/linear_problem.h"

namespace vesta {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

LmOptions Options(LinearSolverKind kind) {
  LmOptions options;
  options.max_iterations = 200;
  options.function_tolerance = 1e-14;
  options.normal_system.linear_solver = kind;
  options.normal_system.pcg = {.max_iterations = 50, .relative_tolerance = 1e-12, .model_tolerance = 0};
  return options;
}

TEST(Bounds, HoldTheMinimumOnTheFace) {
  Cpu backend;
  for (const auto kind : {LinearSolverKind::kPcg, LinearSolverKind::kDenseQr, LinearSolverKind::kLsmr}) {
    ResidualBlocks<Rosenbrock, Cpu> inner(2, std::vector<Rosenbrock>(1));
    BoundedProblem<Cpu> problem(inner, {-kInf, -kInf}, {0.5, kInf});
    Cpu::Vector x = Vector({-1.2, 1});
    const LmSummary summary = SolveLm<Cpu>(Options(kind), backend, problem, x.view());
    EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
    EXPECT_EQ(x[0], 0.5) << ToString(kind);
    EXPECT_NEAR(x[1], 0.25, 1e-7) << ToString(kind);
  }
}

TEST(Bounds, ThatDoNotBindChangeNothing) {
  Cpu backend;
  ResidualBlocks<Rosenbrock, Cpu> inner(2, std::vector<Rosenbrock>(1));
  BoundedProblem<Cpu> problem(inner, {-100, -100}, {100, 100});
  Cpu::Vector x = Vector({-1.2, 1}), y = Vector({-1.2, 1});
  const LmOptions options = Options(LinearSolverKind::kDenseQr);
  SolveLm<Cpu>(options, backend, problem, x.view());
  SolveLm<Cpu>(options, backend, inner, y.view());
  EXPECT_NEAR(x[0], y[0], 1e-8);
  EXPECT_NEAR(x[1], y[1], 1e-8);
}

// The minima at all vertices, edges and faces of a box agree with a search over all sets of active bounds.
TEST(Bounds, ABoxAroundALinearProblem) {
  Cpu backend;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    srand(seed);
    const Eigen::MatrixXd a = Eigen::MatrixXd::Random(6, 3);
    const Eigen::VectorXd b = 2 * Eigen::VectorXd::Random(6);
    LinearProblem inner({{a, b}});
    BoundedProblem<Cpu> problem(inner, {-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3});
    double best = kInf;
    for (int set = 0; set < 27; ++set) {
      Eigen::Vector3d x;
      std::vector<int> free;
      for (int k = 0, s = set; k < 3; ++k, s /= 3) {
        x[k] = 0.3 * (s % 3 - 1);
        if (s % 3 == 1) free.push_back(k);
      }
      if (!free.empty()) {
        Eigen::MatrixXd columns(6, static_cast<Index>(free.size()));
        for (std::size_t k = 0; k < free.size(); ++k) columns.col(static_cast<Index>(k)) = a.col(free[k]);
        const Eigen::VectorXd solved = test::LeastSquares(columns, b - test::Apply(a, x));
        for (std::size_t k = 0; k < free.size(); ++k) x[free[k]] = solved[static_cast<Index>(k)];
      }
      if (x.cwiseAbs().maxCoeff() <= 0.3) best = std::min(best, 0.5 * (test::Apply(a, x) - b).squaredNorm());
    }
    Cpu::Vector x(3);
    const LmSummary summary = SolveLm<Cpu>(Options(LinearSolverKind::kDenseQr), backend, problem, x.view());
    EXPECT_LE(summary.final_cost, best * (1 + 1e-9)) << seed << summary.FullReport();
    EXPECT_TRUE(problem.IsFeasible(x));
  }
}

// The minimum without bounds is (1, -2). At the minimum with x1 >= 0, (-0.8, 0), the clipped step moves x0 alone, and
// the model predicts an increase. This is not a fault of the derivatives.
struct Slanted {
  static constexpr int kResiduals = 2, kParameters = 2;
  template <class T>
  void operator()(const T* p, T* r) const {
    r[0] = p[0] + T(0.9) * p[1] + T(0.8);
    r[1] = T(0.4) * p[1] + T(0.8);
  }
};

TEST(Bounds, AnIncreaseByAClippedStepIsNoFault) {
  for (const double y : {0.0, 0.3}) {
    ResidualBlocks<Slanted, Cpu> inner(2, std::vector<Slanted>(1));
    BoundedProblem<Cpu> problem(inner, {-kInf, 0}, {kInf, kInf});
    Cpu::Vector x = Vector({0.5, y});
    LmOptions options;
    options.gradient_tolerance = 0;
    Cpu backend;
    const LmSummary summary = SolveLm<Cpu>(options, backend, problem, x.view());
    EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
    EXPECT_NEAR(x[0], -0.8, 1e-5);
    EXPECT_EQ(x[1], 0);
    // The message of a solve that ends after a rejected step recommends CheckProblem if it suspects the derivatives.
    for (options.max_iterations = 1; options.max_iterations < 12; ++options.max_iterations) {
      Cpu::Vector short_x = Vector({0.5, y});
      const LmSummary limited = SolveLm<Cpu>(options, backend, problem, short_x.view());
      EXPECT_THAT(limited.message, testing::Not(testing::HasSubstr("CheckProblem"))) << options.max_iterations;
    }
  }
}

// The joint angles of an arm with links of length 1 and 1.5. The target is out of reach.
struct TwoLinkArm {
  static constexpr int kResiduals = 2, kParameters = 2;
  static constexpr double kTarget[2] = {1.595, 2.842};
  template <class T>
  void operator()(const T* joints, T* r) const {
    using std::cos, std::sin;
    const T both = joints[0] + joints[1];
    r[0] = cos(joints[0]) + T(1.5) * cos(both) - T(kTarget[0]);
    r[1] = sin(joints[0]) + T(1.5) * sin(both) - T(kTarget[1]);
  }
};

TEST(Bounds, JointLimitsOfAnArmAreNoFault) {
  constexpr double kLower = -0.5, kUpper = 0.7;
  Cpu backend;
  ResidualBlocks<TwoLinkArm, Cpu> inner(2, std::vector<TwoLinkArm>(1));
  BoundedProblem<Cpu> problem(inner, {kLower, kLower}, {kUpper, kUpper});
  // The second link points to the target.
  const double link = std::atan2(TwoLinkArm::kTarget[1] - std::sin(kUpper), TwoLinkArm::kTarget[0] - std::cos(kUpper));
  for (const double start : {0.0, 0.1, 0.3, -0.2}) {
    Cpu::Vector x = Vector({start, start});
    const LmSummary summary = SolveLm<Cpu>(Options(LinearSolverKind::kDenseQr), backend, problem, x.view());
    EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
    EXPECT_EQ(x[0], kUpper);
    EXPECT_NEAR(x[1], link - kUpper, 1e-6);
    LmOptions options;
    for (options.max_iterations = 1; options.max_iterations < 20; ++options.max_iterations) {
      Cpu::Vector short_x = Vector({start, start});
      const LmSummary limited = SolveLm<Cpu>(options, backend, problem, short_x.view());
      EXPECT_THAT(limited.message, testing::Not(testing::HasSubstr("CheckProblem"))) << options.max_iterations;
    }
  }
}

TEST(Bounds, RefuseWhatIsEmptyAndAStartOutside) {
  Cpu backend;
  ResidualBlocks<Rosenbrock, Cpu> inner(2, std::vector<Rosenbrock>(1));
  EXPECT_THROW(BoundedProblem<Cpu>(inner, {2, 0}, {1, 1}), Error);
  EXPECT_THROW(BoundedProblem<Cpu>(inner, {0}, {1}), Error);
  EXPECT_THROW(BoundedProblem<Cpu>(inner, {std::nan(""), 0}, {1, 1}), Error);
  BoundedProblem<Cpu> problem(inner, {0, 0}, {1, 1});
  Cpu::Vector x = Vector({2, 0.5});
  const LmSummary summary = SolveLm<Cpu>(LmOptions(), backend, problem, x.view());
  EXPECT_EQ(summary.status, LmStatus::kInfeasible);
  EXPECT_EQ(summary.message, "the start violates a bound: entry 0: 2 is not within [0, 1]; move it inside");
  EXPECT_EQ(x[0], 2);
}

}  // namespace
}  // namespace vesta
