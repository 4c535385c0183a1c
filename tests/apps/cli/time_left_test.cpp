// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "apps/cli/print.h"

namespace vesta::app {
namespace {

gs::TrainProgress At(gs::Stage stage, int iteration, double seconds) {
  gs::TrainProgress progress;
  progress.stage = stage;
  progress.iteration = iteration, progress.iterations = 10;
  progress.seconds = seconds;
  return progress;
}

// How long the first stage's first iteration took is not known; the second one begins where the first one ended.
TEST(TimeLeft, FollowsFromWhatHasBeenSeenOfTheStage) {
  TimeLeft left;
  EXPECT_TRUE(std::isnan(left.Observe(At(gs::Stage::kAdam, 1, 100))));
  EXPECT_DOUBLE_EQ(left.Observe(At(gs::Stage::kAdam, 3, 104)), 2 * 7);
  EXPECT_DOUBLE_EQ(left.Observe(At(gs::Stage::kAdam, 10, 118)), 0);
  EXPECT_DOUBLE_EQ(left.Observe(At(gs::Stage::kLm, 1, 123)), 5 * 9);
}

}  // namespace
}  // namespace vesta::app
