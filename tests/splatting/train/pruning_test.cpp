// SPDX-License-Identifier: Apache-2.0
// Trainings that prune Gaussians.
#include <gtest/gtest.h>

#include <vector>

#include "splatting/train/trainer.h"
#include "tests/splatting/train/training_scene.h"

namespace vesta::gs {
namespace {

// With twice the Gaussians needed.
TEST(Pruning, TakesGaussiansOutByAndBy) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = test::ShortTraining(80, 0);
  options.density.enabled = false;
  options.pruning = {.keep_fraction = 0.5, .begin = 0.25, .end = 0.5, .every = 0.05};
  std::vector<Index> counts;
  TrainCallbacks callbacks;
  callbacks.progress = [&](const TrainProgress& p) { counts.push_back(p.gaussians); };
  const TrainResult result = Train(scene, options, {}, callbacks);
  const Index all = static_cast<Index>(scene.points.size());
  ASSERT_EQ(counts.size(), 80U);
  EXPECT_EQ(counts[18], all);
  EXPECT_LT(counts[29], all);
  EXPECT_GT(counts[29], all / 2);
  EXPECT_EQ(counts[39], all / 2);
  EXPECT_EQ(result.model.count, all / 2);
  EXPECT_GT(result.history.back().train.psnr, result.history.front().train.psnr);
  test::ExpectLastRowIsOf(result, scene, options.background);
}

TEST(Pruning, OfAGivenModelLeavesTheOthersInOrder) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = PrunePresetOptions("balanced");
  options.adam.iterations = 60;
  options.pruning.keep_fraction = 0.5;
  SplatModel model = test::RandomModel(60, 1, 7);
  const TrainResult result = Refine(scene, model, options, {}, {});
  EXPECT_EQ(result.model.count, 30);
  options.pruning.keep_fraction = 1;
  EXPECT_EQ(Refine(scene, model, options, {}, {}).model.count, 60);
  EXPECT_EQ(RefinePresetOptions("balanced").pruning.keep_fraction, 1);
}

}  // namespace
}  // namespace vesta::gs
