// SPDX-License-Identifier: Apache-2.0
// Problems whose solve cannot succeed: it must not end as converged, and must say why.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"
#include "tests/solver/faulty_problem.h"

namespace vesta {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

bool Says(const LmSummary& summary, const std::string& text) {
  return summary.message.find(text) != std::string::npos && summary.message.find('\n') == std::string::npos;
}

class FalseConvergence : public ::testing::TestWithParam<LinearSolverKind> {
 protected:
  LmSummary Solve(Problem<Cpu>& problem) {
    options_.normal_system.linear_solver = GetParam();
    return SolveLm<Cpu>(options_, backend_, problem, x_.view());
  }
  LmOptions options_;
  Cpu backend_;
  Cpu::Vector x_ = Vector({1, 2, 3});
};

TEST_P(FalseConvergence, ADiagonalOfZerosFreezesColumnsThatHaveAGradient) {
  FaultyProblem problem;
  problem.on_diagonal = [](Cpu::VectorView d) { Cpu().Fill(0, d); };
  const LmSummary summary = Solve(problem);
  EXPECT_EQ(summary.status, LmStatus::kFrozenGradient) << summary.BriefReport();
  EXPECT_TRUE(Says(summary, "DiagJTJ")) << summary.message;
  EXPECT_EQ(x_[0], 1);
}

TEST_P(FalseConvergence, OneColumnFrozenThoughItHasAGradient) {
  FaultyProblem problem;
  problem.on_diagonal = [](Cpu::VectorView d) { d[1] = 0; };
  const double before = problem.Cost(x_);
  const LmSummary summary = Solve(problem);
  EXPECT_EQ(summary.status, LmStatus::kFrozenGradient) << summary.BriefReport();
  EXPECT_TRUE(Says(summary, "entry 1")) << summary.message;
  EXPECT_LT(summary.final_cost, before) << "the others move all the same";
}

TEST_P(FalseConvergence, ANegativeDiagonal) {
  FaultyProblem problem;
  problem.on_diagonal = [](Cpu::VectorView d) { d[2] = -d[2]; };
  const LmSummary summary = Solve(problem);
  EXPECT_EQ(summary.status, LmStatus::kBadDiagonal) << summary.BriefReport();
  EXPECT_TRUE(Says(summary, "entry 2")) << summary.message;
}

TEST_P(FalseConvergence, ADiagonalOfNaN) {
  FaultyProblem problem;
  problem.on_diagonal = [](Cpu::VectorView d) { d[1] = kNaN; };
  const LmSummary summary = Solve(problem);
  EXPECT_EQ(summary.status, LmStatus::kBadDiagonal) << summary.BriefReport();
  EXPECT_TRUE(Says(summary, "entry 1")) << summary.message;
}

TEST_P(FalseConvergence, ADiagonalThatNobodyWrites) {
  FaultyProblem problem;
  problem.skips_diagonal = true;
  const LmSummary summary = Solve(problem);
  EXPECT_EQ(summary.status, LmStatus::kBadDiagonal) << summary.BriefReport();
  EXPECT_TRUE(Says(summary, "not written")) << summary.message;
}

TEST_P(FalseConvergence, AGradientThatNobodyWrites) {
  FaultyProblem problem;
  problem.skips_transpose = true;
  const LmSummary summary = Solve(problem);
  EXPECT_EQ(summary.status, LmStatus::kNonFinite) << summary.BriefReport();
  EXPECT_TRUE(Says(summary, "gradient")) << summary.message;
  EXPECT_TRUE(Says(summary, "not written")) << summary.message;
}

// A point turned by a unit quaternion, seen from where it is not.
struct Turned {
  template <class T>
  bool operator()(const T* q, T* r) const {
    r[0] = q[0] * q[0] + q[1] * q[1] - q[2] * q[2] - q[3] * q[3] - T(1);
    return true;
  }
};

TEST_P(FalseConvergence, AQuaternionOfZerosAtTheStart) {
  BlockProblem problem;
  problem.AddParameterBlock(2);
  const int rotation = problem.AddParameterBlock(4, std::make_shared<QuaternionManifold>());
  problem.AddResidualBlock(std::make_shared<AutoDiffCost<Turned, 1, 4>>(), nullptr, {rotation});
  x_ = Vector({0, 0, 0, 0, 0, 0});
  const LmSummary summary = Solve(problem);
  EXPECT_EQ(summary.status, LmStatus::kDegenerateStart) << summary.BriefReport();
  EXPECT_TRUE(Says(summary, "parameter block 1")) << summary.message;
  // Held constant it does not matter.
  problem.SetConstant(rotation);
  EXPECT_TRUE(IsConverged(Solve(problem).status));
}

TEST_P(FalseConvergence, ADirectionOfZerosAtTheStart) {
  BlockProblem problem;
  const int direction = problem.AddParameterBlock(4, std::make_shared<UnitVectorManifold>(4));
  problem.AddResidualBlock(std::make_shared<AutoDiffCost<Turned, 1, 4>>(), nullptr, {direction});
  x_ = Vector({0, 0, 0, 0});
  EXPECT_EQ(Solve(problem).status, LmStatus::kDegenerateStart);
}

TEST_P(FalseConvergence, AGradientOfTheWrongSign) {
  FaultyProblem problem;
  const auto negate = [](Cpu::ConstVectorView, Cpu::VectorView out) { Cpu().Axpby(-1.0, out, 0.0, out); };
  // What is wrong in the step by each solver: normal equations see J^T, the others J.
  (GetParam() == LinearSolverKind::kDenseQr ? problem.on_jacobian : problem.on_transpose) = negate;
  const LmSummary summary = Solve(problem);
  EXPECT_EQ(summary.status, LmStatus::kNoDecrease) << summary.BriefReport();
  EXPECT_TRUE(Says(summary, "CheckProblem")) << summary.message;
  EXPECT_EQ(summary.num_accepted, 0);
}

// r = x^2 + 1 with a derivative of the wrong sign.
struct WrongSign final : CostFunction {
  WrongSign() : CostFunction(1, {1}) {}
  bool Evaluate(const double* const* p, double* r, double** j) const override {
    r[0] = p[0][0] * p[0][0] + 1;
    if (j && j[0]) j[0][0] = -2 * p[0][0];
    return true;
  }
};

TEST_P(FalseConvergence, ADerivativeOfTheWrongSign) {
  BlockProblem problem;
  problem.AddResidualBlock(std::make_shared<WrongSign>(), nullptr, {problem.AddParameterBlock(1)});
  x_ = Vector({2});
  const LmSummary summary = Solve(problem);
  EXPECT_EQ(summary.status, LmStatus::kNoDecrease) << summary.BriefReport();
  EXPECT_TRUE(Says(summary, "are the derivatives right?")) << summary.message;
  // Nor by its rounding.
  options_.function_tolerance = options_.gradient_tolerance = options_.parameter_tolerance = 0;
  x_ = Vector({2});
  const LmSummary endless = Solve(problem);
  EXPECT_FALSE(IsConverged(endless.status)) << endless.message;
  EXPECT_TRUE(Says(endless, "are the derivatives right?")) << endless.message;
}

// LSMR solves with J and J^T, and where these are not adjoint its steps go uphill by the model too.
TEST(FalseConvergenceOfLsmr, AModelThatPredictsAnIncrease) {
  FaultyProblem problem;
  problem.on_transpose = [](Cpu::ConstVectorView, Cpu::VectorView g) { Cpu().Axpby(-1.0, g, 0.0, g); };
  LmOptions options;
  options.normal_system.linear_solver = LinearSolverKind::kLsmr;
  Cpu backend;
  Cpu::Vector x = Vector({1, 2, 3});
  const LmSummary summary = SolveLm<Cpu>(options, backend, problem, x.view());
  EXPECT_EQ(summary.status, LmStatus::kNoDecrease) << summary.BriefReport();
  EXPECT_TRUE(Says(summary, "J and J^T are not adjoint?")) << summary.message;
  // The gain ratio has the sign of the change.
  for (const LmIteration& row : summary.iterations) EXPECT_GE(row.rho * row.cost_change, 0) << summary.FullReport();
  // The same where a limit ends it.
  options.max_iterations = 5;
  x = Vector({1, 2, 3});
  const LmSummary limited = SolveLm<Cpu>(options, backend, problem, x.view());
  EXPECT_EQ(limited.status, LmStatus::kMaxIterations);
  EXPECT_TRUE(Says(limited, "J and J^T are not adjoint?")) << limited.message;
}

INSTANTIATE_TEST_SUITE_P(Solvers, FalseConvergence,
                         ::testing::Values(LinearSolverKind::kPcg, LinearSolverKind::kLsmr, LinearSolverKind::kDenseQr),
                         [](const auto& each) {
                           std::string name = ToString(each.param);
                           std::erase(name, ' ');
                           return name;
                         });

}  // namespace
}  // namespace vesta
