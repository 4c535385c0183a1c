// SPDX-License-Identifier: Apache-2.0
// The bridge returns a result, or a failure, where ceres::Solve returns one: constant and unused parameter blocks,
// bounds and options.
#include <ceres/ceres.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "solver/ceres/ceres_problem.h"
#include "solver/ceres/ceres_solve.h"
#include "solver/covariance.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

using ceres_bridge::Solve;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// exp(a t) - exp(0.2 t): the minimum is a = 0.2.
struct Growth {
  double t;
  template <class T>
  bool operator()(const T* a, T* r) const {
    r[0] = exp(a[0] * t) - exp(0.2 * t);
    return true;
  }
};
struct Thousand {
  template <class T>
  bool operator()(const T* b, T* r) const {
    r[0] = 1000.0 * b[0];
    return true;
  }
};

// The growth a from 2, beside the residual 1000 b with b = 1 constant. The block c is in no residual block.
struct Fit {
  Fit() {
    for (const double t : {0.5, 1.0, 1.5}) {
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Growth, 1, 1>(new Growth{t}), nullptr, &a);
    }
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Thousand, 1, 1>(new Thousand), nullptr, &b);
    problem.SetParameterBlockConstant(&b);
  }
  double a = 2, b = 1, c = 7, quaternion[4] = {0, 0, 0, 0};
  ceres::Problem problem;
};

ceres::Solver::Options Silent() {
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  return options;
}

ceres::Solver::Summary SolveByCeres(const ceres::Solver::Options& options, ceres::Problem& problem) {
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary;
}

TEST(CeresReturns, TheFixedCost) {
  Fit ours, theirs;
  const ceres::Solver::Summary expected = SolveByCeres(Silent(), theirs.problem);
  const LmSummary summary = Solve(Silent(), ours.problem);
  ASSERT_EQ(expected.termination_type, ceres::CONVERGENCE);
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_NEAR(theirs.a, 0.2, 1e-8);
  EXPECT_NEAR(ours.a, 0.2, 1e-8);
  EXPECT_EQ(summary.fixed_cost, expected.fixed_cost);
  EXPECT_NEAR(summary.initial_cost, expected.initial_cost, 1e-9);
  EXPECT_NEAR(summary.final_cost, expected.final_cost, 1e-9);
  EXPECT_NEAR(summary.iterations.front().cost, expected.iterations.front().cost, 1e-9);
  EXPECT_NEAR(summary.iterations.back().cost, expected.iterations.back().cost, 1e-9);
  EXPECT_EQ(summary.num_residuals, expected.num_residuals_reduced);
}

TEST(CeresReturns, AFixedCostThatIsNotFinite) {
  Fit ours, theirs;
  ours.b = theirs.b = kInfinity;
  EXPECT_EQ(SolveByCeres(Silent(), theirs.problem).termination_type, ceres::FAILURE);
  const LmSummary summary = Solve(Silent(), ours.problem);
  EXPECT_EQ(summary.status, LmStatus::kNonFinite);
  EXPECT_THAT(summary.message, IsLineWith("3"));
  EXPECT_EQ(ours.a, 2);
}

TEST(CeresReturns, UnusedBlocksKeepTheirValues) {
  Fit ours, theirs;
  for (Fit* one : {&ours, &theirs}) {
    one->problem.AddParameterBlock(one->quaternion, 4, new ceres::QuaternionManifold);
    one->problem.AddParameterBlock(&one->c, 1);
    one->problem.SetParameterUpperBound(&one->c, 0, 5);
  }
  EXPECT_EQ(SolveByCeres(Silent(), theirs.problem).termination_type, ceres::CONVERGENCE);
  const LmSummary summary = Solve(Silent(), ours.problem);
  EXPECT_TRUE(IsConverged(summary.status)) << summary.message;
  for (const Fit* one : {&ours, &theirs}) {
    EXPECT_NEAR(one->a, 0.2, 1e-8);
    EXPECT_EQ(one->c, 7);
    EXPECT_EQ(one->quaternion[0], 0);
  }
}

// Ceres returns zeros for an unused block, as for a constant one. Here both have an empty covariance.
TEST(CeresReturns, CovariancesBesideUnusedBlocks) {
  Fit fit;
  fit.problem.AddParameterBlock(&fit.c, 1);
  Solve(Silent(), fit.problem);
  const double* a = &fit.a;
  const double* c = &fit.c;
  ceres::Covariance theirs({});
  ASSERT_TRUE(theirs.Compute(std::vector<std::pair<const double*, const double*>>{{a, a}, {c, c}}, &fit.problem));
  double of_a = 0, of_c = 1;
  ASSERT_TRUE(theirs.GetCovarianceBlock(a, a, &of_a));
  ASSERT_TRUE(theirs.GetCovarianceBlock(c, c, &of_c));
  EXPECT_EQ(of_c, 0);
  ceres_bridge::CeresProblem bridge(fit.problem);
  const std::pair<int, int> pairs[] = {{bridge.block(a), bridge.block(a)}, {bridge.block(c), bridge.block(c)}};
  const BlockCovariance ours = EstimateBlockCovariance(bridge.problem(), bridge.Gather(), pairs);
  ASSERT_EQ(ours.blocks.size(), 2U);
  EXPECT_NEAR(ours.blocks[0](0, 0), of_a, 1e-9 * of_a);
  EXPECT_TRUE(ours.blocks[1].values.empty());
  const Covariance all = EstimateCovariance(bridge.problem(), bridge.Gather());
  ASSERT_EQ(all.size, 1);
  EXPECT_NEAR(all(0, 0), of_a, 1e-9 * of_a);
}

TEST(CeresReturns, AFailureForReversedBounds) {
  Fit ours, theirs;
  for (Fit* one : {&ours, &theirs}) {
    one->problem.SetParameterLowerBound(&one->a, 0, 3);
    one->problem.SetParameterUpperBound(&one->a, 0, 1.5);
  }
  EXPECT_EQ(SolveByCeres(Silent(), theirs.problem).termination_type, ceres::FAILURE);
  const LmSummary summary = Solve(Silent(), ours.problem);
  EXPECT_EQ(summary.status, LmStatus::kInfeasible);
  EXPECT_THAT(summary.message, IsLineWith("3", "1.5"));
  EXPECT_EQ(ours.a, 2);
}

// Ceres refuses equal bounds. The bridge keeps the entry at that value.
TEST(CeresReturns, EqualBoundsFixAnEntry) {
  Fit ours, theirs;
  for (Fit* one : {&ours, &theirs}) {
    one->problem.SetParameterLowerBound(&one->a, 0, 0.5);
    one->problem.SetParameterUpperBound(&one->a, 0, 0.5);
  }
  EXPECT_EQ(SolveByCeres(Silent(), theirs.problem).termination_type, ceres::FAILURE);
  EXPECT_TRUE(IsConverged(Solve(Silent(), ours.problem).status));
  EXPECT_EQ(ours.a, 0.5);
}

TEST(CeresReturns, TheStartAtATimeLimitOfZero) {
  Fit ours, theirs;
  ceres::Solver::Options options = Silent();
  options.max_solver_time_in_seconds = 0;
  const ceres::Solver::Summary expected = SolveByCeres(options, theirs.problem);
  const LmSummary summary = Solve(options, ours.problem);
  EXPECT_EQ(expected.termination_type, ceres::NO_CONVERGENCE);
  EXPECT_EQ(summary.status, LmStatus::kTimeLimit);
  EXPECT_EQ(summary.iterations.size(), expected.iterations.size());
  EXPECT_NEAR(summary.final_cost, expected.final_cost, 1e-9);
  EXPECT_EQ(ours.a, 2);
}

TEST(CeresReturns, AFailureForInvalidOptions) {
  const std::vector<std::pair<const char*, std::function<void(ceres::Solver::Options&)>>> invalid = {
      {"max_num_iterations", [](auto& o) { o.max_num_iterations = -1; }},
      {"max_solver_time_in_seconds", [](auto& o) { o.max_solver_time_in_seconds = -1; }},
      {"function_tolerance", [](auto& o) { o.function_tolerance = std::nan(""); }},
      {"initial_trust_region_radius", [](auto& o) { o.initial_trust_region_radius = 0; }},
      {"min_trust_region_radius", [](auto& o) { o.min_trust_region_radius = 1e10; }},
      {"eta", [](auto& o) { o.eta = 0, o.linear_solver_type = ceres::CGNR; }},
      {"num_threads", [](auto& o) { o.num_threads = 0; }},
  };
  for (const auto& [name, edit] : invalid) {
    Fit ours, theirs;
    ceres::Solver::Options options = Silent();
    edit(options);
    EXPECT_EQ(SolveByCeres(options, theirs.problem).termination_type, ceres::FAILURE) << name;
    const LmSummary summary = Solve(options, ours.problem);
    EXPECT_EQ(summary.status, LmStatus::kInvalidOptions) << name;
    EXPECT_TRUE(IsFailure(summary.status));
    EXPECT_NE(summary.message.find(name), std::string::npos) << summary.message;
    EXPECT_TRUE(std::isnan(summary.initial_cost));
    EXPECT_EQ(ours.a, 2);
  }
  // Ceres aborts the program.
  Fit ours;
  ceres::Solver::Options options = Silent();
  options.min_lm_diagonal = 0;
  EXPECT_EQ(Solve(options, ours.problem).status, LmStatus::kInvalidOptions);
  LmOptions lm;
  lm.max_iterations = -1;
  const LmSummary summary = Solve(lm, ours.problem);
  EXPECT_EQ(summary.status, LmStatus::kInvalidOptions);
  EXPECT_THAT(summary.message, IsLineWith("max_iterations", "-1"));
}

TEST(CeresReturns, AResultForAnUnboundedRadius) {
  Fit ours, theirs;
  ceres::Solver::Options options = Silent();
  options.max_trust_region_radius = kInfinity;
  EXPECT_EQ(SolveByCeres(options, theirs.problem).termination_type, ceres::CONVERGENCE);
  EXPECT_TRUE(IsConverged(Solve(options, ours.problem).status));
  EXPECT_NEAR(ours.a, 0.2, 1e-8);
}

}  // namespace
}  // namespace vesta
