// SPDX-License-Identifier: Apache-2.0
// Problems that cannot be solved: the solve must not report convergence, and must state the reason.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"
#include "tests/solver/faulty_problem.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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

struct Fault {
  std::function<void(FaultyProblem&)> make;
  LmStatus status;
  std::vector<std::string> tokens;
};

TEST_P(FalseConvergence, OfDiagonalsAndGradientsIsNamed) {
  const std::vector<Fault> faults = {
      {[](FaultyProblem& p) { p.on_diagonal = [](Cpu::VectorView d) { Cpu().Fill(0, d); }; },
       LmStatus::kGradientInZeroColumn,
       {"DiagJTJ"}},
      {[](FaultyProblem& p) { p.on_diagonal = [](Cpu::VectorView d) { d[1] = 0; }; },
       LmStatus::kGradientInZeroColumn,
       {"1"}},
      {[](FaultyProblem& p) { p.on_diagonal = [](Cpu::VectorView d) { d[2] = -d[2]; }; },
       LmStatus::kBadDiagonal,
       {"2"}},
      {[](FaultyProblem& p) { p.on_diagonal = [](Cpu::VectorView d) { d[1] = kNaN; }; }, LmStatus::kBadDiagonal, {"1"}},
      {[](FaultyProblem& p) { p.skips_diagonal = true; }, LmStatus::kBadDiagonal, {"DiagJTJ", "0", "nan"}},
      {[](FaultyProblem& p) { p.skips_transpose = true; }, LmStatus::kNonFinite, {"0", "nan"}}};
  for (const Fault& fault : faults) {
    SCOPED_TRACE(testing::PrintToString(fault.tokens));
    FaultyProblem problem;
    fault.make(problem);
    x_ = Vector({1, 2, 3});
    const double before = problem.Cost(x_);
    const LmSummary summary = Solve(problem);
    EXPECT_EQ(summary.status, fault.status) << summary.BriefReport();
    EXPECT_THAT(summary.message, IsLineWith());
    EXPECT_THAT(summary.message, HasEachToken(fault.tokens));
    // With one zero column the other parameters still move; with three, x does not move.
    if (fault.status != LmStatus::kGradientInZeroColumn) continue;
    EXPECT_EQ(summary.final_cost < before, fault.tokens[0] == "1");
    EXPECT_EQ(x_[0] == 1, fault.tokens[0] != "1");
  }
}

// One coordinate of a point rotated by a unit quaternion, minus 1.
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
  EXPECT_THAT(summary.message, IsLineWith("1"));
  // A constant block of zeros is accepted.
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
  // The mistake that affects the step of each solver: normal equations use J^T, the others J.
  (GetParam() == LinearSolverKind::kDenseQr ? problem.on_jacobian : problem.on_transpose) = negate;
  const LmSummary summary = Solve(problem);
  EXPECT_EQ(summary.status, LmStatus::kNoDecrease) << summary.BriefReport();
  EXPECT_THAT(summary.message, IsLineWith("CheckProblem"));
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
  EXPECT_THAT(summary.message, testing::AllOf(IsLineWith("CheckProblem"), testing::Not(HasTokens("J^T"))));
  // Rounding must not count as convergence either.
  options_.function_tolerance = options_.gradient_tolerance = options_.parameter_tolerance = 0;
  x_ = Vector({2});
  const LmSummary endless = Solve(problem);
  EXPECT_FALSE(IsConverged(endless.status)) << endless.message;
  EXPECT_THAT(endless.message, testing::AllOf(IsLineWith("CheckProblem"), testing::Not(HasTokens("J^T"))));
}

// LSMR solves with J and J^T. If these are not adjoint, its steps increase even the model.
TEST(FalseConvergenceOfLsmr, AModelThatPredictsAnIncrease) {
  FaultyProblem problem;
  problem.on_transpose = [](Cpu::ConstVectorView, Cpu::VectorView g) { Cpu().Axpby(-1.0, g, 0.0, g); };
  LmOptions options;
  options.normal_system.linear_solver = LinearSolverKind::kLsmr;
  Cpu backend;
  Cpu::Vector x = Vector({1, 2, 3});
  const LmSummary summary = SolveLm<Cpu>(options, backend, problem, x.view());
  EXPECT_EQ(summary.status, LmStatus::kNoDecrease) << summary.BriefReport();
  EXPECT_THAT(summary.message, IsLineWith("CheckProblem", "J^T"));
  // The gain ratio has the sign of the cost change.
  for (const LmIteration& row : summary.iterations) EXPECT_GE(row.rho * row.cost_change, 0) << summary.FullReport();
  // The message is the same if the iteration limit ends the solve.
  options.max_iterations = 5;
  x = Vector({1, 2, 3});
  const LmSummary limited = SolveLm<Cpu>(options, backend, problem, x.view());
  EXPECT_EQ(limited.status, LmStatus::kMaxIterations);
  EXPECT_THAT(limited.message, IsLineWith("CheckProblem", "J^T"));
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
