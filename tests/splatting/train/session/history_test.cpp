// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/session/history.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>

#include "splatting/train/session/session.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/thread_ranks.h"

namespace vesta::gs {
namespace {

using test::TrainingScene;

TEST(RecordedHistory, TellsOfItsLastRow) {
  const Scene scene = TrainingScene();
  const TrainCallbacks callbacks;
  TrainingSession session(scene, TrainOptions(), 0, callbacks);
  RecordedHistory& history = session.history();
  EXPECT_TRUE(history.empty());
  EXPECT_FALSE(history.ends_with(Stage::kAdam));
  EXPECT_EQ(history.training_psnr(), 0);
  EXPECT_EQ(history.held_out_psnr(), 0);
  Evaluation evaluation;
  for (const Stage stage : {Stage::kAdam, Stage::kLm}) {
    evaluation.train.psnr += 20, evaluation.held_out.psnr += 10;
    history.Record(stage, 3, {7, [&] { return evaluation; }, {}});
    EXPECT_TRUE(history.ends_with(stage));
    EXPECT_EQ(history.training_psnr(), evaluation.train.psnr);
    EXPECT_EQ(history.held_out_psnr(), evaluation.held_out.psnr);
  }
  ASSERT_EQ(history.rows().size(), 2u);
  EXPECT_EQ(history.rows()[1].gaussians, 7);
  EXPECT_EQ(history.rows()[1].iteration, 3);
}

// Until an evaluation is timed, the prediction is half the time of training on the same number of pixels.
TEST(RecordedHistory, ForeseesTheNextEvaluation) {
  const Scene scene = TrainingScene();
  const TrainCallbacks callbacks;
  TrainingSession session(scene, TrainOptions(), 0, callbacks);
  EXPECT_DOUBLE_EQ(session.history().SecondsAhead(1e-3), 0.5e-3 * 12 * 40 * 30);
  const auto slow = [] {
    ::usleep(2000);
    return Evaluation();
  };
  session.history().Record(Stage::kAdam, 1, {0, slow, {}});
  EXPECT_GE(session.history().SecondsAhead(0), 0.002);
  EXPECT_LT(session.history().SecondsAhead(1e3), 1e3);
  EXPECT_GE(session.clock().Paused(), 0.002) << "the clock is paused";
}

using test::TrainingScene;

// The limit includes evaluations and the predicted next step.
TEST(EarlyEnd, TimeLimitIsOfAllTime) {
  const Scene scene = TrainingScene();
  TrainOptions options;
  options.time_limit = 100;
  const TrainCallbacks callbacks;
  TrainingSession session(scene, options, 50, callbacks);
  EXPECT_FALSE(session.early_end().ShouldStop(10));
  EXPECT_TRUE(session.early_end().ShouldStop(60));
  EXPECT_TRUE(session.early_end().ShouldStop()) << "it stays stopped";
  options.time_limit = 0;
  TrainingSession unlimited(scene, options, 1e6, callbacks);
  EXPECT_FALSE(unlimited.early_end().ShouldStop(1e6));
}

// Only the clock of rank 0 ends the training.
TEST(EarlyEnd, TimeLimitIsByTheClockOfTheFirst) {
  const Scene scene = TrainingScene();
  TrainOptions options;
  options.time_limit = 100;
  for (const int late : {0, 1}) {
    vesta::test::OnThreadRanks(2, [&](Communicator& ranks) {
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
  EXPECT_TRUE(session.early_end().misses_target()) << "nothing was measured yet";
  for (const double psnr : {31.0, 29.0, 30.0}) {
    record(session, psnr);
    EXPECT_EQ(session.early_end().has_reached_target(), psnr >= 30) << psnr;
    EXPECT_EQ(session.early_end().misses_target(), psnr < 30) << psnr;
  }
}

const ProcessGroup kAlone;

TEST(TimeBudget, ATwentiethIsForRowsOfTheHistory) {
  TrainOptions options;
  options.time_limit = 100;
  const TrainingClock fresh(50, 0), has_evaluated(50, 2);
  EXPECT_TRUE(TimeBudget(options, kAlone, fresh).HasTimeToRecord(2));
  EXPECT_FALSE(TimeBudget(options, kAlone, fresh).HasTimeToRecord(5)) << "5 of 55 seconds";
  EXPECT_FALSE(TimeBudget(options, kAlone, has_evaluated).HasTimeToRecord(2)) << "4 of 54 seconds";
  options.time_limit = 0;
  EXPECT_TRUE(TimeBudget(options, kAlone, fresh).HasTimeToRecord(1e6));
}

// Time is reserved for writing the result, and a quarter for LM if enabled.
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
