// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "splatting/train/forecast/forecast.h"

namespace vesta::gs {
namespace {

TEST(GrowthForecast, FollowsWhatHasGrown) {
  GrowthForecast growth;
  EXPECT_FALSE(growth.is_known());
  EXPECT_GT(growth.After(1000, 9), 2000) << "what is usual";
  EXPECT_EQ(growth.After(1000, 0), 1000);
  for (const Index after : {1200, 1300, 1400}) growth.Observe(1000, after);
  EXPECT_FALSE(growth.is_known());
  growth.Observe(1000, 1500);
  ASSERT_TRUE(growth.is_known());
  const double fall = (growth.After(1000, 1) / 1000 - 1) / 0.5;
  EXPECT_GT(fall, 0.7);
  EXPECT_LT(fall, 0.9);
  EXPECT_NEAR(growth.After(1000, 3), 1000 * (1 + 0.5 * fall) * (1 + 0.5 * fall * fall) * (1 + 0.5 * fall * fall * fall),
              1e-9);
}

TEST(GrowthForecast, OfAModelThatDoesNotGrow) {
  GrowthForecast growth;
  for (int k = 0; k < 4; ++k) growth.Observe(1000, k == 1 ? 900 : 1000);
  EXPECT_TRUE(growth.is_known());
  EXPECT_EQ(growth.After(1000, 5), 1000);
}

}  // namespace
}  // namespace vesta::gs
