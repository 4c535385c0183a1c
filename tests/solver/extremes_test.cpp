// SPDX-License-Identifier: Apache-2.0
// Solves at the limits of floating-point numbers. A solve must always end in a documented status without an exception,
// and never leave x worse than at the start.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>

#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"
#include "tests/solver/linear_problem.h"

namespace vesta {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();

// One residual block over all of x, with residuals and Jacobian from a function.
class Custom final : public CostFunction {
 public:
  using Function = std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd& j)>;
  Custom(int residuals, int parameters, Function f) : CostFunction(residuals, {parameters}), f_(std::move(f)) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override {
    Eigen::VectorXd r = Eigen::VectorXd::Zero(num_residuals());
    Eigen::MatrixXd j = Eigen::MatrixXd::Zero(num_residuals(), block_sizes()[0]);
    f_(Eigen::Map<const Eigen::VectorXd>(x[0], j.cols()), r, j);
    Eigen::Map<Eigen::VectorXd>(residuals, r.size()) = r;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    if (jacobians && jacobians[0]) Eigen::Map<RowMajor>(jacobians[0], j.rows(), j.cols()) = j;
    return true;
  }

 private:
  Function f_;
};

class Extremes : public ::testing::TestWithParam<LinearSolverKind> {
 protected:
  LmOptions Options() const {
    LmOptions options;
    options.max_iterations = 300;
    options.function_tolerance = 1e-15;
    options.gradient_tolerance = 0;
    options.normal_system.linear_solver = GetParam();
    options.normal_system.pcg = {.max_iterations = 200, .relative_tolerance = 1e-13, .model_tolerance = 0};
    options.normal_system.lsmr = {.max_iterations = 200, .relative_tolerance = 1e-13};
    return options;
  }
  // Solves from x, in place, and checks the properties of every solve.
  LmSummary Solve(Problem<Cpu>& problem, Cpu::Vector& x, const LmOptions& options) {
    const double before = problem.Cost(x);
    const Eigen::VectorXd given = AsEigen(x.view());
    LmSummary summary = SolveLm<Cpu>(options, backend_, problem, x.view());
    EXPECT_NE(summary.status, LmStatus::kRunning);
    EXPECT_FALSE(summary.message.empty());
    EXPECT_FALSE(summary.FullReport().empty());
    const double after = problem.Cost(x);
    if (std::isfinite(before)) {
      EXPECT_LE(after, before) << summary.FullReport();
      EXPECT_TRUE(AsEigen(x.view()).allFinite());
    } else {
      EXPECT_EQ(std::memcmp(given.data(), x.data(), static_cast<std::size_t>(x.size()) * sizeof(double)), 0);
    }
    return summary;
  }
  LmSummary Solve(int residuals, const Cpu::Vector& start, Custom::Function f) {
    BlockProblem problem;
    x_.CopyFrom(start.view());
    problem.AddResidualBlock(std::make_shared<Custom>(residuals, static_cast<int>(start.size()), std::move(f)), nullptr,
                             {problem.AddParameterBlock(static_cast<int>(start.size()))});
    return Solve(problem, x_, Options());
  }
  Cpu backend_;
  Cpu::Vector x_;
};

TEST_P(Extremes, ParametersFrom1em12To1e12) {
  // r_k saturates like tanh in each parameter at its own scale; neighbours are coupled.
  constexpr int kSize = 9;
  Eigen::VectorXd scale(kSize);
  for (int k = 0; k < kSize; ++k) scale[k] = std::pow(10.0, 3 * k - 12);
  Cpu::Vector start(kSize);
  AsEigen(start.view()) = 3 * scale;
  const LmSummary summary = Solve(2 * kSize - 1, start, [&](const auto& x, auto& r, auto& j) {
    for (int k = 0; k < kSize; ++k) {
      const double y = x[k] / scale[k] - 1;
      r[k] = y + 0.1 * y * y * y;
      j(k, k) = (1 + 0.3 * y * y) / scale[k];
      if (k == 0) continue;
      r[kSize + k - 1] = x[k] / scale[k] - x[k - 1] / scale[k - 1];
      j(kSize + k - 1, k) = 1 / scale[k];
      j(kSize + k - 1, k - 1) = -1 / scale[k - 1];
    }
  });
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  for (int k = 0; k < kSize; ++k) EXPECT_NEAR(x_[k] / scale[k], 1, 1e-7) << k;
}

TEST_P(Extremes, RankDeficientAndZeroColumns) {
  // x_0 + x_1 = 1 leaves their difference free; no residual depends on x_2.
  const LmSummary summary = Solve(2, Vector({5, -2, 7}), [](const auto& x, auto& r, auto& j) {
    r << x[0] + x[1] - 1, 2 * (x[0] + x[1] - 1);
    j << 1, 1, 0, 2, 2, 0;
  });
  EXPECT_TRUE(IsConverged(summary.status)) << summary.message;
  EXPECT_LE(summary.final_cost, 1e-20);
  EXPECT_EQ(x_[2], 7);
  EXPECT_NEAR(x_[0] - x_[1], 7, 1e-6) << "the free direction does not move";
  EXPECT_EQ(summary.num_zero_columns, 1);
}

TEST_P(Extremes, ResidualsOf1e150) {
  const LmSummary summary = Solve(4, Vector({2, -3}), [](const auto& x, auto& r, auto& j) {
    r << 1e150 * x[0], 1e150 * (x[1] - 1), 1e150 * (x[0] + x[1]), 1e150;
    j << 1e150, 0, 0, 1e150, 1e150, 1e150, 0, 0;
  });
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_NEAR(x_[0], -1.0 / 3, 1e-7);
  EXPECT_NEAR(x_[1], 2.0 / 3, 1e-7);
  // If the squares overflow, the cost is infinite, and the status reports it.
  const LmSummary overflow = Solve(1, Vector({1}), [](const auto&, auto& r, auto& j) { r[0] = j(0, 0) = 1e160; });
  EXPECT_EQ(overflow.status, LmStatus::kNonFinite);
}

TEST_P(Extremes, Residuals1em150) {
  const LmSummary summary = Solve(2, Vector({2, -3}), [](const auto& x, auto& r, auto& j) {
    r << 1e-150 * x[0], 1e-150 * (x[1] - 1);
    j << 1e-150, 0, 0, 1e-150;
  });
  EXPECT_NE(summary.status, LmStatus::kNonFinite);
  EXPECT_LE(summary.final_cost, summary.initial_cost);
}

TEST_P(Extremes, NotFiniteAtTheStart) {
  for (const double bad : {kNan, kInf, -kInf}) {
    const LmSummary summary = Solve(1, Vector({1}), [&](const auto&, auto& r, auto& j) {
      r[0] = bad;
      j(0, 0) = 1;
    });
    EXPECT_EQ(summary.status, LmStatus::kNonFinite);
    EXPECT_EQ(summary.num_accepted, 0);
  }
  // NaN in x.
  EXPECT_EQ(Solve(1, Vector({kNan}), [](const auto& x, auto& r, auto& j) { r[0] = x[0], j(0, 0) = 1; }).status,
            LmStatus::kNonFinite);
}

TEST_P(Extremes, JacobianNotFiniteAtTheStart) {
  for (const double bad : {kNan, kInf}) {
    const LmSummary summary = Solve(1, Vector({1, 2}), [&](const auto&, auto& r, auto& j) {
      r[0] = 1;
      j << bad, 1;
    });
    EXPECT_EQ(summary.status, LmStatus::kNonFinite);
    EXPECT_EQ(x_[0], 1);
    EXPECT_EQ(x_[1], 2);
  }
}

TEST_P(Extremes, NotFiniteInMidSolve) {
  // Rosenbrock, with a NaN derivative once x_0 is positive.
  const auto f = [](const auto& x, auto& r, auto& j) {
    r << 1 - x[0], 10 * (x[1] - x[0] * x[0]);
    j << -1, 0, -20 * x[0], 10;
    if (x[0] > 0) j(1, 0) = kNan;
  };
  const LmSummary summary = Solve(2, Vector({-1.2, 1}), f);
  EXPECT_EQ(summary.status, LmStatus::kNonFinite);
  EXPECT_GT(summary.num_accepted, 0);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
}

TEST_P(Extremes, NotFiniteOnlyAtTheTrialPoint) {
  // r = log(x) + 2: the first full step goes below 0, where the logarithm is undefined.
  int bad = 0;
  const LmSummary summary = Solve(1, Vector({4}), [&](const auto& x, auto& r, auto& j) {
    if (x[0] <= 0) ++bad;
    r[0] = std::log(x[0]) + 2;  // root at exp(-2)
    j(0, 0) = 1 / x[0];
  });
  EXPECT_GT(bad, 0) << "the step was meant to overshoot";
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_NEAR(x_[0], std::exp(-2), 1e-8);
}

TEST_P(Extremes, NothingToDo) {
  BlockProblem empty;
  Cpu::Vector none;
  EXPECT_TRUE(IsConverged(Solve(empty, none, Options()).status));
  // Parameters without residuals.
  BlockProblem idle;
  idle.AddParameterBlock(3);
  Cpu::Vector x(3);
  EXPECT_TRUE(IsConverged(Solve(idle, x, Options()).status));
}

TEST_P(Extremes, OneResidual) {
  const LmSummary summary = Solve(1, Vector({3, 4, 5}), [](const auto& x, auto& r, auto& j) {
    r[0] = x[0] * x[1] - 2;
    j << x[1], x[0], 0;
  });
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_LE(summary.final_cost, 1e-15);
  EXPECT_EQ(x_[2], 5);
}

TEST_P(Extremes, ZeroResidualAtTheStart) {
  const LmSummary summary = Solve(2, Vector({1, 2}), [](const auto& x, auto& r, auto& j) {
    r << x[0] - 1, x[1] - 2;
    j << 1, 0, 0, 1;
  });
  EXPECT_EQ(summary.status, LmStatus::kGradientTolerance);
  EXPECT_EQ(summary.final_cost, 0);
  EXPECT_EQ(x_[0], 1);
}

TEST_P(Extremes, ConditionNumber1e12) {
  srand(6);
  const int n = 12;
  const Eigen::MatrixXd u = test::Orthonormal(Eigen::MatrixXd::Random(20, n));
  const Eigen::MatrixXd v = test::Orthonormal(Eigen::MatrixXd::Random(n, n));
  Eigen::VectorXd sigma(n);
  // H = J^T J has condition number 1e12.
  for (int k = 0; k < n; ++k) sigma[k] = std::pow(10.0, -6.0 * k / (n - 1));
  const Eigen::MatrixXd a = test::Multiply(u * sigma.asDiagonal(), v.transpose());
  LinearProblem problem({{a, test::Apply(a, Eigen::VectorXd::Ones(n))}});
  Cpu::Vector x(n);
  LmOptions options = Options();
  options.parameter_tolerance = 0;
  const LmSummary summary = Solve(problem, x, options);
  EXPECT_NE(summary.status, LmStatus::kNonFinite);
  EXPECT_LE(summary.final_cost, 1e-20 * summary.initial_cost) << summary.FullReport();
}

INSTANTIATE_TEST_SUITE_P(Solvers, Extremes,
                         ::testing::Values(LinearSolverKind::kAuto, LinearSolverKind::kPcg, LinearSolverKind::kLsmr,
                                           LinearSolverKind::kDenseQr),
                         [](const auto& each) {
                           std::string name = ToString(each.param);
                           std::erase(name, ' ');
                           return name;
                         });

}  // namespace
}  // namespace vesta
