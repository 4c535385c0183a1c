// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/session/session.h"

#include <gtest/gtest.h>

#include "tests/splatting/train/training_scene.h"

namespace vesta::gs {
namespace {

using test::TrainingScene;

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
  EXPECT_NEAR(session.clock().Total(), 90, 1);
  EXPECT_TRUE(session.early_end().ShouldStop(20));
}

}  // namespace
}  // namespace vesta::gs
