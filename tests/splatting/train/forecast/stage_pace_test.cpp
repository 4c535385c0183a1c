// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "splatting/train/forecast/forecast.h"

namespace vesta::gs {
namespace {

TEST(StagePace, FirstIterationsDoNotCount) {
  StagePace pace;
  EXPECT_FALSE(pace.is_known());
  pace.Observe(true, 100, 10);
  EXPECT_FALSE(pace.is_known());
  pace.Observe(true, 100, 0.1);
  EXPECT_TRUE(pace.is_known());
  EXPECT_DOUBLE_EQ(pace.Seconds(true, 100), 0.1);
  EXPECT_GT(pace.Seconds(true, 200), 0.15) << "more Gaussians take longer";
  EXPECT_LE(pace.Seconds(true, 200), 0.2);
  EXPECT_GT(pace.Seconds(false, 100), 0.1) << "what is usual";
  pace.SetFullBeyondCoarse(0.2);
  EXPECT_DOUBLE_EQ(pace.Seconds(false, 100), 0.3) << "foreseen";
  pace.Observe(false, 100, 10);
  pace.Observe(false, 100, 0.4);
  EXPECT_DOUBLE_EQ(pace.Seconds(false, 100), 0.4) << "measured";
}

TEST(StagePace, FollowsIterationsThatBecomeSlower) {
  StagePace pace;
  for (int it = 0; it < 100; ++it) pace.Observe(false, 100, 0.1);
  for (int it = 0; it < 100; ++it) pace.Observe(false, 100, 0.3);
  EXPECT_NEAR(pace.Seconds(false, 100), 0.3, 0.002);
}

TEST(StagePace, LeavesOutWhatOtherWorkHeldUp) {
  StagePace pace;
  for (int it = 0; it < 100; ++it) pace.Observe(false, 100, it % 20 == 7 ? 50 : 0.1);
  EXPECT_NEAR(pace.Seconds(false, 100), 0.1, 1e-6);
}

TEST(StagePace, OfChangesIsInProportionToTheGaussians) {
  StagePace pace;
  EXPECT_EQ(pace.ChangeSeconds(1000), 0);
  pace.ObserveChange(1000, 2);
  pace.ObserveChange(3000, 6);
  EXPECT_DOUBLE_EQ(pace.ChangeSeconds(5000), 10);
}

}  // namespace
}  // namespace vesta::gs
