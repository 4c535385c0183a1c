// SPDX-License-Identifier: Apache-2.0
#include "solver/check_problem.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "kernels/core/check.h"
#include "problems/toy/toy_problems.h"
#include "solver/block_problem.h"
#include "solver/bounds.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"
#include "tests/solver/faulty_problem.h"
#include "tests/solver/linear_problem.h"

namespace vesta {
namespace {

class CheckProblemTest : public ::testing::Test {
 protected:
  std::string Report(Problem<Cpu>& problem, const Cpu::Vector& x, const CheckProblemOptions& options = {}) {
    return CheckProblem<Cpu>(backend_, problem, x, options).Report();
  }
  // The first faults must contain these texts, in order.
  ProblemCheck ExpectFaults(const std::vector<std::string>& texts) {
    ProblemCheck check = CheckProblem<Cpu>(backend_, faulty_, x_);
    EXPECT_GE(check.faults.size(), texts.size()) << check.Report();
    for (std::size_t i = 0; i < std::min(texts.size(), check.faults.size()); ++i) {
      EXPECT_NE(check.faults[i].find(texts[i]), std::string::npos) << check.Report();
    }
    for (const std::string& fault : check.faults) EXPECT_EQ(fault.find('\n'), std::string::npos);
    return check;
  }
  // Exactly one fault is found, and it contains this text.
  void ExpectOne(const std::string& text) {
    const ProblemCheck check = ExpectFaults({text});
    EXPECT_EQ(check.faults.size(), 1U) << check.Report();
  }
  static constexpr const char* kNone = "no fault was found";
  Cpu backend_;
  FaultyProblem faulty_;
  Cpu::Vector x_ = Vector({1, 2, 3});
};

TEST_F(CheckProblemTest, FindsNothingWhereNothingIsWrong) {
  EXPECT_EQ(Report(faulty_, x_), kNone);
  LinearProblem batches({RandomBatch(8, 5, 1), RandomBatch(6, 5, 2)});
  batches.groups = {{5, 1, 0, 1, 5}};
  EXPECT_EQ(Report(batches, Vector({1, 2, 3, 4, 5})), kNone);
  ResidualBlocks<Rosenbrock, Cpu> rosenbrock(2, std::vector<Rosenbrock>(1));
  EXPECT_EQ(Report(rosenbrock, Vector({-1.2, 1})), kNone);
  EXPECT_EQ(Report(rosenbrock, Vector({1, 1})), kNone) << "residuals of zero";
  BoundedProblem<Cpu> bounded(rosenbrock, {-2, -2}, {-1.2, 1.001});
  EXPECT_EQ(Report(bounded, Vector({-1.2, 1})), kNone) << "at a bound, and close to one";
}

TEST_F(CheckProblemTest, FindsNothingInFloat) {
  using B = CpuBackend<float>;
  ResidualBlocks<ExponentialFit, B> problem(2, ExponentialSamples(50), {}, {.num_batches = 3});
  B backend;
  B::Vector x(2);
  x[0] = 0.3F, x[1] = -0.2F;
  const ProblemCheck check = CheckProblem<B>(backend, problem, x);
  EXPECT_TRUE(check.ok()) << check.Report();
}

// Parameters whose scales differ by 24 orders of magnitude.
struct Scales {
  static constexpr int kResiduals = 2, kParameters = 2;
  template <class T>
  void operator()(const T* p, T* r) const {
    using std::exp;
    r[0] = exp(p[0] * T(1e12)) + p[1] * T(1e-12);
    r[1] = p[1] * p[1] * T(1e-24) - T(3);
  }
};

TEST_F(CheckProblemTest, FindsNothingWhereScalesAreFarApart) {
  ResidualBlocks<Scales, Cpu> problem(2, std::vector<Scales>(1));
  EXPECT_EQ(Report(problem, Vector({3e-13, 5e11})), kNone);
}

TEST_F(CheckProblemTest, AProductThatIsNotAdjoint) {
  faulty_.on_transpose = [](Cpu::ConstVectorView, Cpu::VectorView g) { g[1] *= 1.5; };
  const ProblemCheck check = ExpectFaults({"ApplyJ and ApplyJT are not adjoint"});
  EXPECT_NE(check.Report().find("most at entry 1 of the step"), std::string::npos) << check.Report();
}

TEST_F(CheckProblemTest, ADiagonal) {
  faulty_.on_diagonal = [](Cpu::VectorView d) { d[2] = 0; };
  ExpectOne("DiagJTJ gives 0 for entry 2 of the step, where its column of J has the weighted square 10.09");
}

TEST_F(CheckProblemTest, ABlock) {
  faulty_.on_blocks = [](Cpu::VectorView values) { values[PackedLower(1, 0)] += 1; };
  ExpectOne(
      "BlockGram gives 3 for entry 1 of the step and entry 0 of the step, where their columns of J have the "
      "weighted product 2");
}

TEST_F(CheckProblemTest, StandInsForTheDiagonalAreAllowedWhereSaid) {
  faulty_.on_diagonal = [](Cpu::VectorView d) { d[2] = 7; };
  CheckProblemOptions options;
  options.exact_blocks = false;
  EXPECT_EQ(Report(faulty_, x_, options), kNone);
}

TEST_F(CheckProblemTest, AProductWithH) {
  faulty_.on_product = [](Cpu::ConstVectorView v, Cpu::VectorView Hv) { Hv[0] += 3 * v[0]; };
  ExpectOne("ApplyH(v) and ApplyJT(ApplyW(ApplyJ(v))) must be the same");
}

TEST_F(CheckProblemTest, AGradient) {
  faulty_.on_gradient = [](Cpu::VectorView g) { g[0] += 1; };
  ExpectFaults({"Gradient and ApplyJT(residuals())", "the gradient by entry 0 of the step is"});
}

TEST_F(CheckProblemTest, ACostThatIsNotTheResiduals) {
  faulty_.on_cost = [](double cost) { return 2 * cost; };
  ExpectFaults({"make Gradient the derivative of Cost"});
}

TEST_F(CheckProblemTest, ACostThatIsNoFunction) {
  int calls = 0;
  faulty_.on_cost = [&](double cost) { return cost * (1 + 1e-4 * ++calls); };
  ExpectFaults({"it must depend on x alone"});
}

TEST_F(CheckProblemTest, APlusThatForgetsAnEntry) {
  faulty_.on_plus = [](Cpu::ConstVectorView x, Cpu::ConstVectorView, Cpu::VectorView out) { out[2] = x[2]; };
  ExpectFaults({"Plus does not move x along entry 2 of the step"});
}

TEST_F(CheckProblemTest, APlusThatMovesAtRest) {
  faulty_.on_plus = [](Cpu::ConstVectorView, Cpu::ConstVectorView, Cpu::VectorView out) { out[0] += 1e-3; };
  ExpectFaults({"x and Plus(x, 0) must be the same"});
}

TEST_F(CheckProblemTest, WhatNobodyWrites) {
  faulty_.skips_diagonal = true;
  ExpectOne("DiagJTJ leaves entry 0 of the step NaN, or does not write it");
  faulty_.skips_diagonal = false, faulty_.skips_transpose = true;
  ExpectFaults({"ApplyJT leaves entry 0 of the step"});
}

TEST_F(CheckProblemTest, MistakesThatASolveThrowsAreFaults) {
  faulty_.gives_null = true;
  ExpectOne("returned null");
  faulty_.gives_null = false;
  x_ = Vector({1, 2});
  ExpectOne("x has 2 entries, but the problem has 3 parameters");
}

// Two residuals of two blocks; one derivative is wrong.
class OneWrong final : public CostFunction {
 public:
  explicit OneWrong(bool wrong) : CostFunction(2, {1, 2}), wrong_(wrong) {}
  bool Evaluate(const double* const* p, double* r, double** j) const override {
    r[0] = std::exp(p[0][0]) * p[1][0];
    r[1] = p[0][0] - p[1][1] * p[1][1];
    if (j && j[0]) j[0][0] = r[0], j[0][1] = 1;
    if (j && j[1]) {
      j[1][0] = std::exp(p[0][0]), j[1][1] = 0;
      j[1][2] = 0, j[1][3] = (wrong_ ? 2 : -2) * p[1][1];
    }
    return true;
  }

 private:
  bool wrong_;
};

TEST_F(CheckProblemTest, ADerivativeIsNamedByItsBlocks) {
  BlockProblem problem;
  const int a = problem.AddParameterBlock(1), b = problem.AddParameterBlock(2);
  for (const bool wrong : {false, true, false}) {
    problem.AddResidualBlock(std::make_shared<OneWrong>(wrong), nullptr, {a, b});
  }
  const Cpu::Vector x = Vector({0.2, 1.5, -0.75});
  const ProblemCheck check = CheckProblem<Cpu>(backend_, problem, x);
  ASSERT_EQ(check.faults.size(), 1U) << check.Report();
  EXPECT_EQ(check.faults[0],
            "the derivative of residual 1 of residual block 1 by entry 1 of parameter block 1 is -1.5 in J, by "
            "differences of the residuals 1.5");
  // The check as an option of a solve.
  LmOptions options;
  options.check_derivatives = true;
  Cpu::Vector y = Vector({0.2, 1.5, -0.75});
  const LmSummary summary = SolveLm<Cpu>(options, backend_, problem, y.view());
  EXPECT_EQ(summary.status, LmStatus::kCheckFailed);
  EXPECT_EQ(summary.message, check.faults[0]);
  EXPECT_TRUE(IsFailure(summary.status));
  EXPECT_EQ(y[0], 0.2);
}

TEST_F(CheckProblemTest, ASolveThatIsCheckedIsTheSame) {
  LmOptions options;
  options.check_derivatives = true;
  ResidualBlocks<Rosenbrock, Cpu> problem(2, std::vector<Rosenbrock>(1));
  Cpu::Vector x = Vector({-1.2, 1}), y = Vector({-1.2, 1});
  const LmSummary checked = SolveLm<Cpu>(options, backend_, problem, x.view());
  options.check_derivatives = false;
  SolveLm<Cpu>(options, backend_, problem, y.view());
  EXPECT_TRUE(IsConverged(checked.status)) << checked.message;
  EXPECT_EQ(x[0], y[0]);
  EXPECT_EQ(x[1], y[1]);
}

struct PoseLike {
  template <class T>
  void operator()(const T* q, const T* t, T* r) const {
    r[0] = q[0] * q[1] - q[2] * q[3] + t[0];
    r[1] = q[0] * q[0] + t[1] * t[1] - T(2);
    r[2] = t[0] * t[1] + q[3];
  }
};

// A loss corrects J, so only the gradient can be compared.
TEST_F(CheckProblemTest, LossesAndManifolds) {
  for (const bool wrong : {false, true}) {
    struct Wrong final : Loss {
      // rho' belongs to another rho.
      Value Evaluate(double s) const override { return {std::log1p(s), 0.5 / (1 + s), 0}; }
    };
    BlockProblem problem;
    const int q = problem.AddParameterBlock(4, std::make_shared<QuaternionManifold>());
    const int t = problem.AddParameterBlock(2);
    std::shared_ptr<const Loss> loss = std::make_shared<CauchyLoss>(0.5);
    if (wrong) loss = std::make_shared<Wrong>();
    problem.AddResidualBlock(std::make_shared<AutoDiffCost<PoseLike, 3, 4, 2>>(), loss, {q, t});
    const Cpu::Vector x = Vector({0.5, 0.5, -0.5, 0.5, 1, 2});
    const std::string report = Report(problem, x);
    if (wrong) {
      EXPECT_NE(report.find("make Gradient the derivative of Cost"), std::string::npos) << report;
    } else {
      EXPECT_EQ(report, kNone);
    }
  }
}

TEST_F(CheckProblemTest, OptionsAreChecked) {
  CheckProblemOptions options;
  options.max_columns = 0;
  EXPECT_THROW(CheckProblem<Cpu>(backend_, faulty_, x_, options), Error);
}

}  // namespace
}  // namespace vesta
