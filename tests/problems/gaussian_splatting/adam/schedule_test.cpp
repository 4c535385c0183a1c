#include "problems/gaussian_splatting/adam/schedule.h"

#include <gtest/gtest.h>

namespace vesta::gs {
namespace {

TEST(AdamSchedule, RatesDecayGeometrically) {
  const AdamOptions adam{.iterations = 100, .rate_factor = 5, .rate_decay = 0.25, .cooldown = 0};
  EXPECT_DOUBLE_EQ(RateFactor(adam, 1, 100), 5);
  EXPECT_DOUBLE_EQ(RateFactor(adam, 51, 100), 2.5);
  EXPECT_DOUBLE_EQ(RateFactor(adam, 101, 100), 1.25);
}

TEST(AdamSchedule, CooldownIsTheLastPart) {
  const AdamOptions adam{.iterations = 100, .rate_factor = 5, .rate_decay = 1, .cooldown = 0.2, .cooldown_to = 0.01};
  EXPECT_DOUBLE_EQ(RateFactor(adam, 81, 100), 5);
  EXPECT_NEAR(RateFactor(adam, 91, 100), 0.5, 1e-12);
  EXPECT_NEAR(RateFactor(adam, 101, 100), 0.05, 1e-12);
}

TEST(AdamSchedule, AStageThatEndsSoonerCoolsDownSooner) {
  const AdamOptions adam{.iterations = 100, .rate_factor = 5, .rate_decay = 1, .cooldown = 0.2, .cooldown_to = 0.01};
  EXPECT_DOUBLE_EQ(RateFactor(adam, 41, 50), 5);
  EXPECT_NEAR(RateFactor(adam, 51, 50), 0.05, 1e-12);
}

TEST(AdamSchedule, TheMeanIsOverTheLastPart) {
  const AdamOptions adam{.iterations = 100, .average_part = 0.3};
  EXPECT_FALSE(AveragesAt(adam, 70, 100));
  EXPECT_TRUE(AveragesAt(adam, 75, 100));
  EXPECT_FALSE(AveragesAt(adam, 76, 100));
  EXPECT_TRUE(AveragesAt(adam, 88, 88)) << "the last always";
  EXPECT_FALSE(AveragesAt(adam, 40, 40)) << "it is a part of what was asked for";
  EXPECT_FALSE(AveragesAt({.iterations = 100, .average_part = 0}, 100, 100));
}

TEST(AdamSchedule, CoarseViewsComeFirst) {
  const AdamOptions adam{.iterations = 100, .coarse_part = 0.3};
  EXPECT_TRUE(IsCoarseAt(adam, 1));
  EXPECT_TRUE(IsCoarseAt(adam, 30));
  EXPECT_FALSE(IsCoarseAt(adam, 31));
  EXPECT_FALSE(IsCoarseAt({.iterations = 100, .coarse_part = 0}, 1));
}

TEST(AdamSchedule, EveryViewOnceAnEpoch) {
  ViewOrder order(5, 3);
  for (int epoch = 0; epoch < 4; ++epoch) {
    std::vector<int> times(5, 0);
    for (int k = 0; k < 5; ++k) ++times[order.Next()];
    EXPECT_EQ(times, std::vector<int>(5, 1));
  }
}

}  // namespace
}  // namespace vesta::gs
