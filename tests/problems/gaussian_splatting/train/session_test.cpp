#include "problems/gaussian_splatting/train/session.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>

#include "tests/problems/gaussian_splatting/train/training_scene.h"

namespace vesta::gs {
namespace {

using test::TrainingScene;

// Evaluation is part of the time, and so is what is foreseen of it.
TEST(TrainingSession, TimeLimitIsOfAllTime) {
  const Scene scene = TrainingScene();
  TrainOptions options;
  options.time_limit = 100;
  const TrainCallbacks callbacks;
  TrainingSession session(scene, options, 50, callbacks);
  EXPECT_FALSE(session.ShouldStop(10));
  EXPECT_TRUE(session.HasTimeToRecord(2));
  EXPECT_FALSE(session.HasTimeToRecord(5)) << "a twentieth, of 55";
  EXPECT_TRUE(session.ShouldStop(60));
  EXPECT_TRUE(session.ShouldStop()) << "once and for all";
  // Half of what training on as many pixels takes, until one has been measured.
  EXPECT_DOUBLE_EQ(session.EvaluationAhead(1e-3), 0.5e-3 * 12 * 40 * 30);

  TrainingSession evaluating(scene, options, 99.999, callbacks);
  evaluating.Record(Stage::kAdam, 1,
                    {0,
                     [] {
                       ::usleep(2000);
                       return Evaluation();
                     },
                     {}});
  EXPECT_GE(evaluating.EvaluationAhead(0), 0.002);
  EXPECT_LT(evaluating.EvaluationAhead(1e3), 1e3) << "measured";
  EXPECT_GE(evaluating.TotalSeconds(), 100);
  EXPECT_TRUE(evaluating.ShouldStop());
  options.time_limit = 0;
  TrainingSession unlimited(scene, options, 1e6, callbacks);
  EXPECT_FALSE(unlimited.ShouldStop(1e6));
  EXPECT_TRUE(unlimited.HasTimeToRecord(1e6));
}

// A training that goes on has had the evaluations of before.
TEST(TrainingSession, EvaluationsBeforeABreakAreTimeToo) {
  const Scene scene = TrainingScene();
  TrainOptions options;
  options.time_limit = 100;
  Checkpoint checkpoint;
  checkpoint.run.scene = FingerprintOf(scene);
  checkpoint.run.seconds = 20, checkpoint.run.eval_seconds = 60;
  TrainCallbacks callbacks;
  callbacks.resume = &checkpoint;
  TrainingSession session(scene, options, 10, callbacks);
  EXPECT_NEAR(session.Seconds(), 30, 1);
  EXPECT_NEAR(session.EvalSeconds(), 0, 1) << "of this process";
  EXPECT_NEAR(session.TotalSeconds(), 90, 1);
  EXPECT_TRUE(session.ShouldStop(20));
}

// What is saved every so many minutes is due so many after where a training goes on, not at once.
TEST(TrainingSession, IntervalsBeginWhereATrainingGoesOn) {
  const Scene scene = TrainingScene();
  Checkpoint checkpoint;
  checkpoint.run.scene = FingerprintOf(scene);
  checkpoint.run.seconds = 1000;
  TrainCallbacks callbacks;
  callbacks.resume = &checkpoint;
  int taken = 0;
  callbacks.snapshot = [&](Stage, int, const splat::Model<float>&) { ++taken; };
  const auto take = [&](double minutes) {
    callbacks.snapshot_every.minutes = minutes;
    TrainingSession session(scene, TrainOptions(), 0, callbacks);
    session.SnapshotWhereDue(Stage::kAdam, 1, [] { return splat::Model<float>(); });
    return taken;
  };
  EXPECT_EQ(take(10), 0);
  EXPECT_EQ(take(1e-9), 1);
}

// Room to write is kept, and a quarter for LM where it is asked for.
TEST(TrainingSession, AdamHasTheTimeThatOthersLeave) {
  const Scene scene = TrainingScene();
  const TrainCallbacks callbacks;
  TrainOptions options;
  const auto seconds = [&] { return TrainingSession(scene, options, 50, callbacks).SecondsForAdam(0); };
  EXPECT_TRUE(std::isinf(seconds()));
  options.time_limit = 100;
  const double alone = seconds();
  EXPECT_LT(alone, 50);
  EXPECT_GT(alone, 47);
  options.lm.iterations = 1;
  EXPECT_NEAR(seconds(), alone - 25, 1);
}

}  // namespace
}  // namespace vesta::gs
