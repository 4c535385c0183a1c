// SPDX-License-Identifier: Apache-2.0
// Ends by time limit or target PSNR, and the prediction of the end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "splatting/train/trainer.h"
#include "tests/splatting/train/is_note.h"
#include "tests/splatting/train/training_scene.h"

namespace vesta::gs {
namespace {

using test::ExpectLastRowIsOf;
using test::ShortTraining;
using test::TrainingScene;

TEST(Trainer, TimeLimitEndsEarlyWithAModel) {
  const Scene scene = TrainingScene();
  TrainOptions options = ShortTraining(1000, 5);
  options.time_limit = 10;
  // Loading alone exceeded the time limit.
  const TrainResult result = Train(scene, options, {.seconds = 20}, {});
  EXPECT_TRUE(result.stopped);
  ASSERT_EQ(result.history.size(), 1u);
  EXPECT_EQ(result.history[0].iteration, 1);
  EXPECT_GE(result.history[0].seconds, 20);
  ExpectLastRowIsOf(result, scene, {0, 0, 0});
}

// The time limit is used, also with several views per iteration: an overestimated cost of pruning must not end the
// training early.
TEST(Trainer, AShortTimeLimitIsUsed) {
  const Scene scene = TrainingScene();
  for (const int views : {1, 6}) {
    TrainOptions options = ShortTraining(1000000, 0);
    options.pruning = PruningOptions();
    options.adam.batch_size = views;
    options.time_limit = 0.3;
    EXPECT_GT(Train(scene, options, {}, {}).history.back().iteration, 15) << views;
  }
}

TEST(Trainer, EndsWhereTheViewsHeldOutHaveEnough) {
  Scene scene = TrainingScene();
  HoldOut(&scene.views);
  TrainOptions options = ShortTraining(200, 3);
  options.target_psnr = 1;  // reached from the start
  const TrainResult early = Train(scene, options, {}, {});
  ASSERT_EQ(early.history.size(), 1u);
  EXPECT_EQ(early.history[0].stage, Stage::kAdam) << "LM does not run";
  EXPECT_EQ(early.history[0].iteration, 10) << "the first row of 20";
  EXPECT_FALSE(early.stopped);
  EXPECT_THAT(early.notes, testing::IsEmpty());
  ExpectLastRowIsOf(early, scene, {0, 0, 0});

  options.target_psnr = 99;
  const TrainResult all = Train(scene, options, {}, {});
  EXPECT_EQ(all.history.back().stage, Stage::kLm);
  EXPECT_THAT(all.notes, testing::Contains(test::IsNote(notes::kMissesTarget, "99.00")));
  // Held-out views do not affect the training.
  for (View& view : scene.views) {
    if (view.role != ViewRole::kHeldOut) continue;
    for (float& value : view.image.rgb) value = 1 - value;
  }
  EXPECT_EQ(Train(scene, options, {}, {}).model.data, all.model.data);
}

TEST(Trainer, ForeseesItsEnd) {
  const Scene scene = TrainingScene();
  TrainOptions options = ShortTraining(200, 0);
  TrainCallbacks callbacks;
  std::vector<Prediction> told;
  callbacks.predicted = [&](const Prediction& prediction) { told.push_back(prediction); };
  constexpr double kHeldMib = 1e4;
  Train(scene, options, {0, kHeldMib}, callbacks);
  ASSERT_FALSE(told.empty());
  const Prediction& last = told.back();
  EXPECT_FALSE(last.is_first_guess);
  EXPECT_GT(last.seconds, last.at_seconds);
  EXPECT_GT(last.mib, kHeldMib);
  EXPECT_LE(last.gaussians, static_cast<double>(options.density.max_gaussians));
  EXPECT_GE(last.gaussians, 60);
}

}  // namespace
}  // namespace vesta::gs
