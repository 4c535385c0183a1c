// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/trust_region/nonmonotonic.h"

#include <gtest/gtest.h>

#include "solver/internal/trust_region/step_control.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

TEST(NonmonotonicReference, ComparesWithTheReference) {
  NonmonotonicReference reference(2);
  reference.Start(100);
  // At first both ratios are the same.
  EXPECT_EQ(reference.GainRatio(0.5, 90, 20), 0.5);
  EXPECT_TRUE(reference.OnAccept(90, 20));
  EXPECT_TRUE(reference.OnAccept(40, 30));
  // Up by 10: since the start the cost has decreased by 50, of 20 + 30 + 50 predicted.
  EXPECT_EQ(reference.GainRatio(-0.2, 50, 50), 0.5);
  EXPECT_EQ(reference.GainRatio(0.7, 50, 50), 0.7);
  EXPECT_FALSE(reference.OnAccept(50, 50));
  EXPECT_EQ(reference.lowest(), 40);
  // The second step without a new lowest cost. The highest cost since then, 50, becomes the reference.
  EXPECT_FALSE(reference.OnAccept(45, 10));
  EXPECT_EQ(reference.GainRatio(-9, 60, 10), -0.5);
  EXPECT_EQ(reference.GainRatio(-9, 46, 10), 0.2);
  EXPECT_TRUE(reference.OnAccept(39, 10));
  EXPECT_EQ(reference.lowest(), 39);
}

TEST(NonmonotonicReference, NoStepsMeansTheGainRatioAlone) {
  NonmonotonicReference reference(0);
  reference.Start(100);
  EXPECT_FALSE(reference.enabled());
  reference.OnAccept(50, 50);
  EXPECT_EQ(reference.GainRatio(-0.2, 60, 50), -0.2);
  StepControlOptions options;
  options.max_consecutive_nonmonotonic_steps = -1;
  EXPECT_THAT([&] { options.Validate(); }, ThrowsError(kBadArgument, "max_consecutive_nonmonotonic_steps", "-1"));
}

}  // namespace
}  // namespace vesta
