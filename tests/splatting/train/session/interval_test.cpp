// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "splatting/train/session/training_clock.h"

namespace vesta::gs {
namespace {

TEST(IntervalTimer, CountsAdamsIterationsAndTakesAllOfLms) {
  IntervalTimer timer(0);
  const Interval every{.iterations = 10};
  EXPECT_FALSE(every.never());
  EXPECT_FALSE(timer.IsDue(every, Stage::kAdam, 9, 1e6));
  EXPECT_TRUE(timer.IsDue(every, Stage::kAdam, 10, 1e6));
  EXPECT_FALSE(timer.IsDue(every, Stage::kAdam, 11, 1e6));
  EXPECT_TRUE(timer.IsDue(every, Stage::kLm, 1, 1e6));
}

TEST(IntervalTimer, CountsMinutesSinceItWasLastDue) {
  IntervalTimer timer(1000);
  const Interval every{.minutes = 2};
  for (const Stage stage : {Stage::kAdam, Stage::kLm}) {
    const double begin = stage == Stage::kAdam ? 1000 : 1130;
    EXPECT_FALSE(timer.IsDue(every, stage, 1, begin + 119));
    EXPECT_TRUE(timer.IsDue(every, stage, 2, begin + 130));
    EXPECT_FALSE(timer.IsDue(every, stage, 3, begin + 131));
  }
}

TEST(IntervalTimer, IsNeverDueWhereNothingIsGiven) {
  IntervalTimer timer(0);
  EXPECT_TRUE(Interval().never());
  EXPECT_FALSE(timer.IsDue(Interval(), Stage::kAdam, 100, 1e9));
  EXPECT_FALSE(timer.IsDue(Interval(), Stage::kLm, 100, 1e9));
}

}  // namespace
}  // namespace vesta::gs
