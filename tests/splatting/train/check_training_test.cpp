// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/check_training.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "kernels/core/check.h"
#include "splatting/train/trainer.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/throws_error.h"

namespace vesta::gs {
namespace {

using test::ShortTraining;
using test::TrainingScene;

TEST(CheckTraining, RefusesBadOptionsAndScenesWithoutTrainingViews) {
  Scene scene = TrainingScene();
  TrainOptions options = ShortTraining(10, 1);
  options.sh_degree = 7;
  EXPECT_THROW(Refine(scene, test::RandomModel(1, 1, 8), options, {}, {}), Error);
  scene.views.resize(1);
  ASSERT_TRUE(scene.views[0].is_test());
  EXPECT_THROW(Train(scene, ShortTraining(10, 1), {}, {}), Error);
}

TEST(CheckTraining, NamesTheViewThatHasNoImageOfItsCamerasSize) {
  Scene scene = TrainingScene();
  View& view = scene.views.back();
  const auto train = [&] { Train(scene, ShortTraining(10, 1), {}, {}); };
  view.image.rgb.pop_back();
  EXPECT_THAT(train, ThrowsError(kBadArgument, view.name));
  view.image.rgb.clear();
  EXPECT_THAT(train, ThrowsError(kBadArgument, view.name));
}

TEST(CheckTraining, ATargetNeedsViewsHeldOut) {
  TrainOptions options = ShortTraining(2, 0);
  options.target_psnr = 20;
  EXPECT_THAT([&] { Train(TrainingScene(), options, {}, {}); },
              ThrowsError(kBadArgument, "train.target_psnr=20", "LoadSceneOptions::hold_out"));
}

TEST(CheckTraining, TheFilterIsThatOfTheScene) {
  TrainOptions options = ShortTraining(2, 0);
  options.eps2d = 0.1;
  Scene scene = TrainingScene();
  EXPECT_THAT([&] { Train(scene, options, {}, {}); },
              ThrowsError(kBadArgument, "train.eps2d=0.1", "0.3", "LoadSceneOptions::eps2d"));
  for (View& view : scene.views) view.camera.eps2d = 0.1;
  EXPECT_EQ(Train(scene, options, {}, {}).model.eps2d, 0.1);
  options.antialias = true;
  EXPECT_THAT([&] { Train(scene, options, {}, {}); },
              ThrowsError(kBadArgument, "train.antialias=true", "LoadSceneOptions::antialiased"));
}

}  // namespace
}  // namespace vesta::gs
