// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/session/session.h"

#include <gtest/gtest.h>

#include "splatting/train/session/interim_output.h"
#include "tests/splatting/train/training_scene.h"

namespace vesta::gs {
namespace {

using test::TrainingScene;

// A resumed training counts the evaluation time before the break.
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
  EXPECT_NEAR(session.EvalSeconds(), 0, 1) << "of this process only";
  EXPECT_NEAR(session.clock().Total(), 90, 1);
  EXPECT_TRUE(session.early_end().ShouldStop(20));
}

using test::TrainingScene;

// An output every few minutes is due after a full interval, not at once.
TEST(InterimOutput, IntervalsBeginWhereATrainingGoesOn) {
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
    session.interim().SnapshotWhereDue(Stage::kAdam, 1, [] { return splat::Model<float>(); });
    return taken;
  };
  EXPECT_EQ(take(10), 0);
  EXPECT_EQ(take(1e-9), 1);
}

}  // namespace

}  // namespace vesta::gs
