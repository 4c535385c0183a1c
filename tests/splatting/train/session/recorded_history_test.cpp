// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include "splatting/train/session/history.h"
#include "splatting/train/session/session.h"
#include "tests/splatting/train/training_scene.h"

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

// Half of what training on as many pixels takes, until an evaluation was measured.
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
  EXPECT_GE(session.clock().Paused(), 0.002) << "the clock stands still";
}

}  // namespace
}  // namespace vesta::gs
