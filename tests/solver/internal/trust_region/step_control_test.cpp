// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/trust_region/step_control.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kernels/core/check.h"

namespace vesta {
namespace {

StepControl Make(StepRule rule) {
  StepControlOptions options = DefaultStepControl(rule);
  options.initial_lambda = 1;
  return StepControl(options);
}

TEST(StepControl, CeresDividesTheRadiusByGrowingFactors) {
  // By hand, for radius = 1 / lambda: an accept at rho = 1 triples it, at 1/2 keeps it, at 1/4 divides it by 1.125;
  // rejects divide by 2, 4, 8 and an accept begins the series anew.
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
  EXPECT_EQ(control.lambda(), 2e-4) << "the series of factors begins there";
  StepControl accepted(options);
  accepted.OnAccept(1.0);
  accepted.OnReject();
  EXPECT_DOUBLE_EQ(accepted.lambda(), 2e-6 / 3) << "a later reject is as any other";
  options.lambda_after_first_reject = -1;
  EXPECT_THROW(options.Validate(), Error);
}

TEST(StepControl, VersionTwoFollowsTheCubicAndDoubles) {
  auto control = Make(StepRule::k3dgsLmV2);
  control.OnAccept(0.75);
  EXPECT_DOUBLE_EQ(control.lambda(), 0.875);
  control.OnAccept(5.0);  // as printed the factor would be negative; at least 1/3
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

}  // namespace
}  // namespace vesta
