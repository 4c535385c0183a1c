// SPDX-License-Identifier: Apache-2.0
// Residual blocks whose parameter blocks are all constant, and parameter blocks that no residual block uses, do not
// take part in a solve.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "kernels/core/archive.h"
#include "kernels/core/check.h"
#include "solver/block_problem.h"
#include "solver/bounds.h"
#include "solver/check_problem.h"
#include "solver/covariance.h"
#include "solver/levenberg_marquardt.h"
#include "tests/solver/dense_operator.h"
#include "tests/support/linearize_at.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

// exp(a t) - exp(0.2 t): the minimum is a = 0.2.
struct Growth {
  double t;
  template <class T>
  void operator()(const T* a, T* r) const {
    using std::exp;
    r[0] = exp(a[0] * T(t)) - T(exp(0.2 * t));
  }
};

// factor * b, which counts its evaluations.
class Scaled final : public CostFunction {
 public:
  explicit Scaled(double factor) : CostFunction(1, std::vector<int>{1}), factor_(factor) {}
  bool Evaluate(const double* const* p, double* r, double** jacobians) const override {
    ++evaluations;
    r[0] = factor_ * p[0][0];
    if (jacobians && jacobians[0]) jacobians[0][0] = factor_;
    return true;
  }
  mutable int evaluations = 0;

 private:
  double factor_;
};

// The growth a from 2, behind the residual `factor` b with b = 1 constant.
struct GrowthBesideAConstant {
  explicit GrowthBesideAConstant(double factor = 1000) : scaled(std::make_shared<Scaled>(factor)) {
    const int b = problem.AddParameterBlock(1), a = problem.AddParameterBlock(1);
    problem.SetConstant(b);
    problem.AddResidualBlock(scaled, nullptr, {b});
    for (const double t : {0.5, 1.0, 1.5}) {
      problem.AddResidualBlock(std::make_shared<AutoDiffCost<Growth, 1, 1>>(Growth{t}), nullptr, {a});
    }
  }
  std::shared_ptr<Scaled> scaled;
  BlockProblem problem;
  Cpu::Vector x = Vector({1, 2});
};

TEST(FixedCost, StoppingTestsDoNotUseIt) {
  GrowthBesideAConstant fit;
  const double start = fit.problem.Cost(fit.x);
  const LmSummary summary = SolveLm(fit.problem, fit.x);
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_NEAR(fit.x[1], 0.2, 1e-8);
  EXPECT_EQ(fit.x[0], 1);
  EXPECT_EQ(summary.fixed_cost, 5e5);
  EXPECT_NEAR(summary.initial_cost, start, 1e-9);
  EXPECT_NEAR(summary.final_cost, 5e5, 1e-9);
  EXPECT_EQ(summary.iterations.front().cost, summary.initial_cost);
  EXPECT_EQ(summary.iterations.back().cost, summary.final_cost);
  EXPECT_EQ(summary.num_residuals, 3);
}

TEST(FixedCost, IsEvaluatedOnce) {
  GrowthBesideAConstant fit;
  LmOptions options;
  options.line_search.enabled = true;
  options.line_search.unit_fraction = 1;
  const LmSummary summary = SolveLm(fit.problem, fit.x, options);
  EXPECT_GT(summary.num_subset_evaluations, 2);
  EXPECT_EQ(fit.scaled->evaluations, 1);
}

TEST(FixedCost, IsPartOfTheCost) {
  GrowthBesideAConstant fit;
  const double fixed = fit.problem.FixedCost(fit.x), variable = fit.problem.VariableCost(fit.x);
  EXPECT_EQ(fixed, 5e5);
  EXPECT_NEAR(fixed + variable, fit.problem.Cost(fit.x), 1e-9);
  ASSERT_EQ(fit.problem.num_units(), 3);
  const Index units[] = {0, 1, 2};
  EXPECT_NEAR(fit.problem.Cost(fit.x, units), variable, 1e-12);
  EXPECT_EQ(LinearizeAt(fit.problem, fit.x)->num_residuals(), 3);
  EXPECT_EQ(fit.problem.NameResidual(0, 0), "residual 0 of residual block 1");
  EXPECT_EQ(fit.problem.NameTangent(0), "entry 0 of parameter block 1");
  Cpu backend;
  const ProblemCheck check = CheckProblem<Cpu>(backend, fit.problem, fit.x);
  EXPECT_TRUE(check.ok()) << check.faults.front();
}

TEST(FixedCost, BoundsPassItOn) {
  GrowthBesideAConstant fit;
  fit.problem.SetBounds(1, 0, 0.5, 3);
  const LmSummary summary = SolveLm(fit.problem, fit.x);
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_EQ(fit.x[1], 0.5);
  EXPECT_EQ(summary.fixed_cost, 5e5);
}

// A constant block of 1e9 must not enlarge the step that parameter_tolerance allows, which is relative to |x|.
TEST(FixedCost, ConstantEntriesAreNotInTheParameterTolerance) {
  GrowthBesideAConstant fit(0);
  fit.x[0] = 1e9;
  const LmSummary summary = SolveLm(fit.problem, fit.x);
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_NEAR(fit.x[1], 0.2, 1e-8);
  EXPECT_EQ(fit.problem.VariableNorm(fit.x), fit.x[1]);
  Cpu::Vector moved = Vector({0, fit.x[1] - 3});
  EXPECT_EQ(fit.problem.VariableMaxChange(fit.x, moved), 3);
  moved[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(fit.problem.VariableMaxChange(fit.x, moved)));
}

TEST(FixedCost, ThatIsNotFiniteEndsTheSolve) {
  GrowthBesideAConstant fit;
  fit.x[0] = std::numeric_limits<double>::infinity();
  const LmSummary summary = SolveLm(fit.problem, fit.x);
  EXPECT_EQ(summary.status, LmStatus::kNonFinite);
  EXPECT_THAT(summary.message, IsLineWith("0"));
  EXPECT_EQ(fit.x[1], 2);
}

TEST(FixedCost, OfAProblemWithoutFreeBlocks) {
  GrowthBesideAConstant fit;
  fit.problem.SetConstant(1);
  const double cost = fit.problem.Cost(fit.x);
  const LmSummary summary = SolveLm(fit.problem, fit.x);
  EXPECT_TRUE(IsConverged(summary.status));
  EXPECT_EQ(summary.fixed_cost, cost);
  EXPECT_EQ(summary.final_cost, cost);
  EXPECT_EQ(EstimateCovariance(fit.problem, fit.x).size, 0);
}

// A resumed solve evaluates the fixed cost again, and its iterations have the same bits.
TEST(FixedCost, ASavedSolveResumes) {
  Cpu backend;
  const LmOptions options;
  GrowthBesideAConstant whole, broken;
  const LmSummary expected = SolveLm(whole.problem, whole.x, options);
  auto stepper = std::make_unique<LmStepper<Cpu>>(options, backend, broken.problem, broken.x);
  while (!stepper->done()) {
    stepper->Step();
    if (stepper->done()) break;
    std::string bytes;
    ArchiveWriter writer([&](std::string_view piece) { bytes.append(piece); });
    const double cost = stepper->cost();
    stepper->Save(writer);
    EXPECT_EQ(stepper->cost(), cost);
    ArchiveReader reader(bytes);
    stepper = std::make_unique<LmStepper<Cpu>>(options, backend, broken.problem, reader);
    EXPECT_EQ(stepper->cost(), cost);
  }
  EXPECT_EQ(stepper->x()[1], whole.x[1]);
  const LmSummary& found = stepper->summary();
  EXPECT_EQ(found.status, expected.status);
  EXPECT_EQ(found.initial_cost, expected.initial_cost);
  EXPECT_EQ(found.final_cost, expected.final_cost);
  EXPECT_EQ(found.fixed_cost, expected.fixed_cost);
  ASSERT_EQ(found.iterations.size(), expected.iterations.size());
  for (std::size_t k = 0; k < found.iterations.size(); ++k) {
    EXPECT_EQ(found.iterations[k].cost, expected.iterations[k].cost) << k;
    EXPECT_EQ(found.iterations[k].cost_change, expected.iterations[k].cost_change) << k;
  }
}

// A growth with three more parameter blocks that no residual block uses: a quaternion of zeros, a number outside its
// bounds, and a large number.
struct GrowthWithUnusedBlocks : GrowthBesideAConstant {
  GrowthWithUnusedBlocks() {
    quaternion = problem.AddParameterBlock(4, std::make_shared<QuaternionManifold>());
    bounded = problem.AddParameterBlock(1);
    problem.SetBounds(bounded, 0, 0, 5);
    large = problem.AddParameterBlock(1);
    x = Vector({1, 2, 0, 0, 0, 0, 7, 1e9});
  }
  int quaternion, bounded, large;
};

TEST(UnusedBlocks, KeepTheirValues) {
  GrowthWithUnusedBlocks fit;
  const LmSummary summary = SolveLm(fit.problem, fit.x);
  EXPECT_TRUE(IsConverged(summary.status)) << summary.message;
  EXPECT_EQ(summary.num_tangent, 1);
  EXPECT_NEAR(fit.x[1], 0.2, 1e-8);
  for (Index k = 2; k < 6; ++k) EXPECT_EQ(fit.x[k], 0);
  EXPECT_EQ(fit.x[6], 7);
  EXPECT_EQ(fit.x[7], 1e9);
  for (const int block : {fit.quaternion, fit.bounded, fit.large}) {
    EXPECT_EQ(fit.problem.tangent_offset(block), -1);
    EXPECT_EQ(fit.problem.tangent_size(block), 0);
  }
}

TEST(UnusedBlocks, LeaveTheCovariancesOfTheOthers) {
  GrowthWithUnusedBlocks fit;
  SolveLm(fit.problem, fit.x);
  const Covariance all = EstimateCovariance(fit.problem, fit.x);
  ASSERT_EQ(all.size, 1);
  ASSERT_EQ(all.rank, 1);
  double h = 0;
  for (const double t : {0.5, 1.0, 1.5}) h += std::pow(t * std::exp(0.2 * t), 2);
  EXPECT_NEAR(all(0, 0), 1 / h, 1e-7 / h);
  const std::pair<int, int> pairs[] = {{1, 1}, {fit.large, fit.large}, {fit.quaternion, 1}};
  const BlockCovariance chosen = EstimateBlockCovariance(fit.problem, fit.x, pairs);
  EXPECT_EQ(chosen.num_singular, 0);
  ASSERT_EQ(chosen.blocks.size(), 3U);
  EXPECT_NEAR(chosen.blocks[0](0, 0), 1 / h, 1e-7 / h);
  EXPECT_TRUE(chosen.blocks[1].values.empty());
  EXPECT_TRUE(chosen.blocks[2].values.empty());
}

// The minimum is (2, 1). With y = 0.5 it is at 5 x = 2.5 + 4 * 1.5.
struct Crossing {
  template <class T>
  void operator()(const T* p, T* r) const {
    r[0] = p[0] + p[1] - T(3.0);
    r[1] = T(2.0) * (p[0] - p[1]) - T(2.0);
  }
};

TEST(EqualBounds, FixAnEntry) {
  const auto expect_fixed = [](Problem<Cpu>& problem) {
    Cpu::Vector x = Vector({-4, 0.5});
    const LmSummary summary = SolveLm(problem, x);
    EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
    EXPECT_EQ(x[1], 0.5);
    EXPECT_NEAR(x[0], 1.7, 1e-7);
    // The entry is masked even if its gradient is zero.
    Cpu::Vector mask = Vector({1, 1});
    dynamic_cast<WithBounds<Cpu>&>(problem).MaskActiveBounds(x, Vector({1, 0}), mask);
    EXPECT_EQ(mask[0], 1);
    EXPECT_EQ(mask[1], 0);
    x[1] = 0.4;
    EXPECT_EQ(SolveLm(problem, x).status, LmStatus::kInfeasible);
  };
  BlockProblem problem;
  problem.AddResidualBlock(std::make_shared<AutoDiffCost<Crossing, 2, 2>>(Crossing{}), nullptr,
                           {problem.AddParameterBlock(2)});
  const double infinity = std::numeric_limits<double>::infinity();
  BoundedProblem<Cpu> bounded(problem, {-infinity, 0.5}, {infinity, 0.5});
  expect_fixed(bounded);
  problem.SetBounds(0, 1, 0.5, 0.5);
  expect_fixed(problem);
  EXPECT_THAT([&] { problem.SetBounds(0, 1, 0.5, 0.25); }, ThrowsError(kBadArgument, "0.5", "0.25"));
}

// Messages have words and values, but no expression or file of the library's code.
TEST(Messages, OfMisuseNameTheBlock) {
  GrowthBesideAConstant fit;
  const auto add_null = [&] { fit.problem.AddResidualBlock(nullptr, nullptr, {0}); };
  EXPECT_THAT(add_null, ThrowsError(kBadArgument, "null", "4"));
  for (const std::optional<Error>& error :
       {ErrorOf(add_null), ErrorOf([&] { fit.problem.AddParameterBlock(0); }), ErrorOf([&] { fit.problem.offset(9); }),
        ErrorOf([&] { fit.problem.tangent_offset(9); }), ErrorOf([&] { fit.problem.tangent_size(-1); })}) {
    ASSERT_TRUE(error.has_value());
    EXPECT_THAT(std::string(error->what()), testing::Not(testing::ContainsRegex("::|->|[(][)]|==|&&|[.]cpp|[.]h:")));
  }
}

}  // namespace
}  // namespace vesta
