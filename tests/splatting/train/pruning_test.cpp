// SPDX-License-Identifier: Apache-2.0
// Trainings that prune Gaussians.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "splatting/pruning/coverage.h"
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

// Growth begins at iteration 20, pruning at 60.
TEST(Pruning, PrecedesEachDensification) {
  const Scene scene = test::TrainingScene();
  TrainOptions options = test::ShortTraining(100, 0);
  options.density.grow_pull = 1e6;  // no growth
  options.density.prune_opa = 0;
  const auto train = [&](double aic_weight, bool densifies) {
    options.pruning.aic_weight = aic_weight;
    options.density.enabled = densifies;
    std::vector<Index> counts;
    TrainCallbacks callbacks;
    callbacks.progress = [&](const TrainProgress& p) { counts.push_back(p.gaussians); };
    Train(scene, options, {}, callbacks);
    EXPECT_EQ(counts.size(), 100U);
    return counts;
  };
  const Index all = static_cast<Index>(scene.points.size());
  const std::vector<Index> pruned = train(100, true);
  EXPECT_EQ(pruned[18], all);
  EXPECT_LT(pruned[19], all);
  EXPECT_EQ(pruned[38], pruned[19]);
  EXPECT_LT(pruned[39], pruned[38]);
  EXPECT_EQ(pruned[58], pruned[39]);
  EXPECT_EQ(train(0, true)[58], all);
  EXPECT_EQ(train(100, false)[58], all);
}

// The optimiser does not move a Gaussian that no view shows.
TEST(Pruning, UnseenGaussiansShrinkUntilTheyAreSmall) {
  const Scene scene = test::TrainingScene();
  SplatModel model = test::RandomModel(60, 1, 7);
  const float log_scales[3] = {-1.5f, -4, -1};
  model.attribute(splat::kMean + 1)[4] = 12;
  for (int k = 0; k < 3; ++k) model.attribute(splat::kLogScale + k)[4] = log_scales[k];
  TrainOptions options = test::ShortTraining(60, 0);
  options.density.enabled = false;
  for (const bool shrinks : {false, true}) {
    options.pruning.shrink_unseen = shrinks;
    const SplatModel result = Refine(scene, model, options, {}, {}).model;
    ASSERT_EQ(result.count, 60);
    // Twice by the largest factor, from 0.012 of an image to less than 0.003.
    const double by = shrinks ? 2 * std::log(kMostShrinkage) : 0;
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(result.attribute(splat::kLogScale + k)[4], log_scales[k] - (k == 1 ? 0 : by), 1e-5);
    }
  }
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
