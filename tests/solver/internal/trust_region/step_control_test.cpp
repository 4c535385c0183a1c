// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/trust_region/step_control.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "kernels/core/check.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

StepControl Make(StepRule rule) {
  StepControlOptions options = DefaultStepControl(rule);
  options.initial_lambda = 1;
  return StepControl(options);
}

TEST(StepControl, CeresDividesTheRadiusByGrowingFactors) {
  // Computed by hand for radius = 1 / lambda. Accepting at rho = 1 triples it, at 1/2 keeps it, at 1/4 divides it by
  // 1.125. Rejections divide it by 2, 4, 8; an acceptance restarts the series.
  auto control = Make(StepRule::kCeres);
  control.OnAccept(1.0);
  EXPECT_DOUBLE_EQ(control.lambda(), 1.0 / 3);
  control.OnAccept(0.5);
  EXPECT_DOUBLE_EQ(control.lambda(), 1.0 / 3);
  control.OnAccept(0.25);
  EXPECT_DOUBLE_EQ(control.lambda(), 1.125 / 3);
  control.OnReject();
  EXPECT_DOUBLE_EQ(control.lambda(), 2 * 1.125 / 3);
  control.OnReject();
  EXPECT_DOUBLE_EQ(control.lambda(), 8 * 1.125 / 3);
  control.OnReject();
  EXPECT_DOUBLE_EQ(control.lambda(), 64 * 1.125 / 3);
  control.OnAccept(0.5);
  control.OnReject();
  EXPECT_DOUBLE_EQ(control.lambda(), 128 * 1.125 / 3);
}

TEST(StepControl, ARefusedFirstStepMayBeginAnew) {
  StepControlOptions options;
  options.initial_lambda = 1e-6;
  options.lambda_after_first_reject = 1e-4;
  StepControl control(options);
  control.OnReject();
  EXPECT_EQ(control.lambda(), 1e-4);
  control.OnReject();
  EXPECT_EQ(control.lambda(), 2e-4) << "the series of factors starts there";
  StepControl accepted(options);
  accepted.OnAccept(1.0);
  accepted.OnReject();
  EXPECT_DOUBLE_EQ(accepted.lambda(), 2e-6 / 3) << "a later rejection is treated as usual";
  StepControl kept(options);
  kept.OnAccept(0.5);
  ASSERT_EQ(kept.lambda(), 1e-6) << "an accepted step may leave lambda unchanged";
  kept.OnReject();
  EXPECT_EQ(kept.lambda(), 2e-6);
  options.lambda_after_first_reject = -1;
  EXPECT_THROW(options.Validate(), Error);
}

TEST(StepControl, VersionTwoFollowsTheCubicAndDoubles) {
  auto control = Make(StepRule::k3dgsLmV2);
  control.OnAccept(0.75);
  EXPECT_DOUBLE_EQ(control.lambda(), 0.875);
  control.OnAccept(5.0);  // the printed formula would give a negative factor; at least 1/3
  EXPECT_DOUBLE_EQ(control.lambda(), 0.875 / 3);
  control.OnReject();
  control.OnReject();
  EXPECT_DOUBLE_EQ(control.lambda(), 4 * 0.875 / 3);
}

TEST(StepControl, TheReleasedCodeIsTheRadiusRuleWithinItsBounds) {
  auto control = Make(StepRule::k3dgsLmCode);
  control.OnReject();
  control.OnReject();
  EXPECT_DOUBLE_EQ(control.lambda(), 8);
  for (int i = 0; i < 20; ++i) control.OnReject();
  EXPECT_EQ(control.lambda(), 1e4);
  EXPECT_TRUE(control.at_upper_bound());
  for (int i = 0; i < 40; ++i) control.OnAccept(1.0);
  EXPECT_EQ(control.lambda(), 1e-4);
}

TEST(StepControl, ThresholdsBelongToTheRules) {
  const struct {
    StepRule rule;
    double threshold;
  } cases[] = {{StepRule::kCeres, 1e-3}, {StepRule::k3dgsLmCode, 0}, {StepRule::k3dgsLmV2, 1e-5}};
  for (const auto& [rule, threshold] : cases) {
    auto control = Make(rule);
    EXPECT_FALSE(control.Accepts(threshold)) << ToString(rule);
    EXPECT_TRUE(control.Accepts(threshold + 1e-9)) << ToString(rule);
    EXPECT_FALSE(control.Accepts(std::numeric_limits<double>::quiet_NaN())) << ToString(rule);
  }
}

TEST(StepControl, OptionsAreChecked) {
  StepControlOptions options;
  options.initial_lambda = 0;
  EXPECT_THROW(options.Validate(), Error);
  options = {};
  options.max_lambda = 1e-9;
  EXPECT_THROW(options.Validate(), Error);
  options = {};
  options.min_relative_decrease = 1;
  EXPECT_THROW(options.Validate(), Error);
}

TEST(ConvergenceDoubt, SpeaksOfWhatRejectedStepsWereToGain) {
  ConvergenceDoubt doubt;
  EXPECT_EQ(doubt.Find(false, 0).Describe(), "");
  doubt.OnReject(3, true);
  doubt.OnReject(1, true);
  EXPECT_THAT(doubt.Find(false, 2).Describe(), HasTokens("3.000e+00"));
  EXPECT_EQ(doubt.Find(false, 3).Describe(), "") << "rounding";
  EXPECT_EQ(doubt.Find(true, 0).Describe(), "") << "a shorter step was accepted";
  doubt.OnReject(std::numeric_limits<double>::quiet_NaN(), true);
  EXPECT_THAT(doubt.Find(false, 2).Describe(), HasTokens("3.000e+00"));
  doubt.OnAccept();
  EXPECT_EQ(doubt.Find(false, 0).Describe(), "");
}

TEST(ConvergenceDoubt, AnIncreaseSaysMoreThanADecrease) {
  ConvergenceDoubt doubt;
  doubt.OnReject(5, true);
  doubt.OnReject(-2, true);
  EXPECT_THAT(doubt.Find(false, 1).Describe(), HasTokens("J^T"));
  EXPECT_EQ(doubt.FindIncrease(1).Describe(), doubt.Find(false, 1).Describe());
  EXPECT_EQ(doubt.FindIncrease(2).Describe(), "");
}

TEST(ConvergenceDoubt, StepsToWhereThereIsNoCostSpeakAgainstAcceptedOnesToo) {
  ConvergenceDoubt doubt;
  doubt.OnReject(5, false);
  for (const bool accepted : {false, true}) EXPECT_THAT(doubt.Find(accepted, 1).Describe(), HasTokens("5.000e+00"));
  EXPECT_EQ(doubt.Find(true, 5).Describe(), "");
}

TEST(LineSearch, ShrinksUntilTheCostRisesAndStepsBack) {
  const LineSearchOptions options{.enabled = true, .shrink = 0.5, .max_evaluations = 20};
  // The minimum is at 0.3: the cost falls at 1, 0.5, 0.25 and rises at 0.125.
  auto result = SearchGamma(options, [](double gamma) { return (gamma - 0.3) * (gamma - 0.3); });
  EXPECT_EQ(result.gamma, 0.25);
  EXPECT_EQ(result.evaluations, 4);
  // The full step is best: two evaluations.
  result = SearchGamma(options, [](double gamma) { return -gamma; });
  EXPECT_EQ(result.gamma, 1);
  EXPECT_EQ(result.evaluations, 2);
}

TEST(LineSearch, InfiniteCostsAreClimbedDownFrom) {
  const LineSearchOptions options{.enabled = true, .shrink = 0.5, .max_evaluations = 20};
  const auto result = SearchGamma(options, [](double gamma) {
    return gamma > 0.2 ? std::numeric_limits<double>::quiet_NaN() : (gamma - 0.1) * (gamma - 0.1);
  });
  EXPECT_EQ(result.gamma, 0.125);
}

TEST(LineSearch, EvaluationsAreLimited) {
  const LineSearchOptions options{.enabled = true, .shrink = 0.5, .max_evaluations = 5};
  const auto result = SearchGamma(options, [](double gamma) { return gamma; });
  EXPECT_EQ(result.evaluations, 5);
  EXPECT_EQ(result.gamma, 0.0625);
}

TEST(LineSearch, UnitsAreSpreadAndTurn) {
  EXPECT_EQ(SpreadUnits(10, 0.3, 0), (std::vector<Index>{0, 3, 6}));
  EXPECT_EQ(SpreadUnits(10, 0.3, 5), (std::vector<Index>{1, 5, 8}));
  EXPECT_EQ(SpreadUnits(1, 0.3, 7), (std::vector<Index>{0}));
  EXPECT_EQ(SpreadUnits(4, 1.0, 3), (std::vector<Index>{0, 1, 2, 3}));
  for (Index turn = 0; turn < 20; ++turn) {
    const auto units = SpreadUnits(7, 0.5, turn);
    EXPECT_EQ(std::set<Index>(units.begin(), units.end()).size(), units.size());
  }
}

}  // namespace
}  // namespace vesta
