// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "splatting/train/session/history.h"
#include "splatting/train/session/session.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/thread_ranks.h"

namespace vesta::gs {
namespace {

using test::TrainingScene;

// With evaluations, and with what is foreseen.
TEST(EarlyEnd, TimeLimitIsOfAllTime) {
  const Scene scene = TrainingScene();
  TrainOptions options;
  options.time_limit = 100;
  const TrainCallbacks callbacks;
  TrainingSession session(scene, options, 50, callbacks);
  EXPECT_FALSE(session.early_end().ShouldStop(10));
  EXPECT_TRUE(session.early_end().ShouldStop(60));
  EXPECT_TRUE(session.early_end().ShouldStop()) << "once and for all";
  options.time_limit = 0;
  TrainingSession unlimited(scene, options, 1e6, callbacks);
  EXPECT_FALSE(unlimited.early_end().ShouldStop(1e6));
}

// Clocks differ; theirs all would end the training by whichever is ahead.
TEST(EarlyEnd, TimeLimitIsByTheClockOfTheFirst) {
  const Scene scene = TrainingScene();
  TrainOptions options;
  options.time_limit = 100;
  for (const int late : {0, 1}) {
    vesta::test::OnThreadRanks(2, [&](Ranks& ranks) {
      TrainCallbacks callbacks;
      callbacks.ranks = &ranks;
      TrainingSession session(scene, options, ranks.rank() == late ? 200 : 0, callbacks);
      EXPECT_EQ(session.early_end().ShouldStop(), late == 0);
    });
  }
}

TEST(EarlyEnd, TargetIsOfTheLatestRow) {
  const Scene scene = TrainingScene();
  TrainOptions options;
  const TrainCallbacks callbacks;
  const auto record = [](TrainingSession& session, double psnr) {
    Evaluation evaluation;
    evaluation.held_out.psnr = psnr;
    session.history().Record(Stage::kAdam, 1, {0, [=] { return evaluation; }, {}});
  };
  TrainingSession without(scene, options, 0, callbacks);
  record(without, 50);
  EXPECT_FALSE(without.early_end().has_reached_target());
  EXPECT_FALSE(without.early_end().misses_target());
  options.target_psnr = 30;
  TrainingSession session(scene, options, 0, callbacks);
  EXPECT_TRUE(session.early_end().misses_target()) << "nothing was measured";
  for (const double psnr : {31.0, 29.0, 30.0}) {
    record(session, psnr);
    EXPECT_EQ(session.early_end().has_reached_target(), psnr >= 30) << psnr;
    EXPECT_EQ(session.early_end().misses_target(), psnr < 30) << psnr;
  }
}

}  // namespace
}  // namespace vesta::gs
