// SPDX-License-Identifier: Apache-2.0
// The Adam stage with several views an iteration.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "splatting/adam/adam_options.h"
#include "splatting/train/settings/training_plan.h"
#include "splatting/train/trainer.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

// The length is given in views.
TEST(ViewsAnIteration, MakeFewerIterations) {
  AdamOptions adam;
  adam.iterations = 20;
  const auto iterations = [&](int views) {
    adam.views_per_iteration = views;
    return NumIterations(adam);
  };
  EXPECT_EQ(iterations(1), 20);
  EXPECT_EQ(iterations(4), 5);
  EXPECT_EQ(iterations(8), 3) << "the last one sees as many as the others";
  EXPECT_EQ(iterations(100), 1);
  adam.iterations = 0;
  EXPECT_EQ(iterations(4), 0);

  TrainOptions options = test::ShortTraining(40, 0);
  options.adam.views_per_iteration = 4;
  EXPECT_EQ(Train(test::TrainingScene(), options, {}, {}).history.back().iteration, 10);
}

TEST(ViewsAnIteration, AreNoMoreThanThereAre) {
  const Scene scene = test::TrainingScene();
  const auto training = [&](int views) {
    TrainOptions options = test::ShortTraining(40, 0);
    options.adam.views_per_iteration = views;
    return [&scene, options] { Train(scene, options, {}, {}); };
  };
  ASSERT_EQ(NumTrainingViews(scene), 10);
  EXPECT_NO_THROW(training(10)());
  EXPECT_THAT(training(11), ThrowsError(kBadArgument, "adam.views_per_iteration=11", "10"));
  EXPECT_THAT(training(0), ThrowsError(kBadArgument, "adam.views_per_iteration=0", "1"));
}

}  // namespace
}  // namespace vesta::gs
