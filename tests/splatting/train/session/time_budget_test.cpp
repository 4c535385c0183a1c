// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "splatting/train/session/history.h"

namespace vesta::gs {
namespace {

const ProcessGroup kAlone;

TEST(TimeBudget, ATwentiethIsForRowsOfTheHistory) {
  TrainOptions options;
  options.time_limit = 100;
  const TrainingClock fresh(50, 0), has_evaluated(50, 2);
  EXPECT_TRUE(TimeBudget(options, kAlone, fresh).HasTimeToRecord(2));
  EXPECT_FALSE(TimeBudget(options, kAlone, fresh).HasTimeToRecord(5)) << "of 55";
  EXPECT_FALSE(TimeBudget(options, kAlone, has_evaluated).HasTimeToRecord(2)) << "4 of 54";
  options.time_limit = 0;
  EXPECT_TRUE(TimeBudget(options, kAlone, fresh).HasTimeToRecord(1e6));
}

// Room to write is kept, and a quarter for LM where it is asked for.
TEST(TimeBudget, AdamHasTheTimeThatOthersLeave) {
  TrainOptions options;
  const TrainingClock clock(50, 0);
  const TimeBudget time(options, kAlone, clock);
  EXPECT_FALSE(time.is_limited());
  EXPECT_TRUE(std::isinf(time.SecondsForAdam()));
  options.time_limit = 100;
  EXPECT_TRUE(time.is_limited());
  const double alone = time.SecondsForAdam();
  EXPECT_LT(alone, 50);
  EXPECT_GT(alone, 47);
  options.lm.iterations = 1;
  EXPECT_NEAR(time.SecondsForAdam(), alone - 25, 1);
}

}  // namespace
}  // namespace vesta::gs
