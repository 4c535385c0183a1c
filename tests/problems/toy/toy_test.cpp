// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "bench/collections/solve_both.h"
#include "problems/toy/toy_problems.h"
#include "solver/check_problem.h"
#include "solver/levenberg_marquardt.h"

namespace vesta {
namespace {

constexpr double kZero[2] = {0, 0};

TEST(Toy, ExponentialFit) {
  const auto both = SolveBoth(MakeSmallProblem(ExponentialSamples(100)), kZero);
  EXPECT_TRUE(both.SameMinimum()) << both.summary.FullReport() << both.cost_ceres;
  for (int k = 0; k < 2; ++k) {
    EXPECT_NEAR(both.x[k], both.x_ceres[k], 1e-9);
    EXPECT_NEAR(both.x[k], kExponentialFitTruth[k], 0.02);
  }
}

TEST(Toy, CheckProblemFindsNoFault) {
  const std::unique_ptr<Problem<SmallProblem::B>> problem = MakeSmallProblem(ExponentialSamples(100)).make(nullptr);
  SmallProblem::B backend;
  SmallProblem::B::Vector x(2);
  x[0] = 0.3, x[1] = 0.1;
  const ProblemCheck check = CheckProblem<SmallProblem::B>(backend, *problem, x);
  EXPECT_TRUE(check.ok()) << check.Report();
}

TEST(Toy, ExponentialFitWithOutliersNeedsARobustLoss) {
  const auto samples = MakeSmallProblem(ExponentialSamples(100, 10));
  const auto plain = SolveBoth(samples, kZero);
  EXPECT_TRUE(plain.SameMinimum()) << plain.summary.FullReport() << plain.cost_ceres;
  const double plain_error = std::abs(plain.x[1] - kExponentialFitTruth[1]);
  EXPECT_GT(plain_error, 0.1);
  const struct {
    const char* name;
    std::shared_ptr<const Loss> ours;
    ceres::LossFunction* theirs;  // owned by the ceres::Problem
  } losses[] = {{"huber", std::make_shared<HuberLoss>(0.1), new ceres::HuberLoss(0.1)},
                {"soft l1", std::make_shared<SoftLOneLoss>(0.1), new ceres::SoftLOneLoss(0.1)},
                {"cauchy", std::make_shared<CauchyLoss>(0.1), new ceres::CauchyLoss(0.1)},
                {"arctan", std::make_shared<ArctanLoss>(0.1), new ceres::ArctanLoss(0.1)}};
  for (const auto& loss : losses) {
    const auto robust = SolveBoth(samples, kZero, loss.ours, loss.theirs);
    EXPECT_TRUE(robust.SameMinimum()) << loss.name << "\n" << robust.summary.FullReport() << robust.cost_ceres;
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(robust.x[k], robust.x_ceres[k], 1e-6) << loss.name;
    EXPECT_LT(std::abs(robust.x[1] - kExponentialFitTruth[1]), 0.25 * plain_error) << loss.name;
  }
}

TEST(Toy, TukeyFromNearby) {
  // The Tukey loss is redescending: at the start, inliers must have weight.
  const double start[2] = {0.28, 0.15};
  const auto robust = SolveBoth(MakeSmallProblem(ExponentialSamples(100, 10)), start, std::make_shared<TukeyLoss>(0.5),
                                new ceres::TukeyLoss(0.5));
  EXPECT_TRUE(robust.SameMinimum()) << robust.summary.FullReport() << robust.cost_ceres;
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(robust.x[k], kExponentialFitTruth[k], 0.02);
}

TEST(Toy, Powell) {
  const auto both = SolveBoth(MakeSmallProblem(std::vector<Powell>(1)), Powell::kStart);
  EXPECT_TRUE(both.SameMinimum()) << both.summary.FullReport() << both.cost_ceres;
  EXPECT_LE(both.cost, 1e-14 * both.start_cost);
}

TEST(Toy, Rosenbrock) {
  const auto both = SolveBoth(MakeSmallProblem(std::vector<Rosenbrock>(1)), Rosenbrock::kStart);
  EXPECT_TRUE(both.SameMinimum()) << both.summary.FullReport() << both.cost_ceres;
  for (const double value : both.x) EXPECT_NEAR(value, 1, 1e-9);
}

TEST(Toy, RosenbrockChainByPcgAlone) {
  // A thousand unknowns with the default, inexact inner solves.
  constexpr Index kSize = 1000;
  using B = CpuBackend<double>;
  ResidualBlocks<Rosenbrock, B> problem(kSize, std::vector<Rosenbrock>(kSize - 1), RosenbrockChain(kSize));
  B backend;
  B::Vector x(kSize);
  backend.Fill(0.5, x);
  LmOptions options;
  options.max_iterations = 200;
  options.function_tolerance = 1e-20;
  const LmSummary summary = SolveLm(options, backend, problem, x.view());
  EXPECT_LE(summary.final_cost, 1e-14 * summary.initial_cost) << summary.FullReport();
  for (const double value : x) EXPECT_NEAR(value, 1, 1e-4);
}

}  // namespace
}  // namespace vesta
