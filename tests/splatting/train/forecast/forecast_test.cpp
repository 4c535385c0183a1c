// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/forecast/forecast.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "splatting/pruning/pruning_options.h"

namespace vesta::gs {
namespace {

TEST(GrowthForecast, FollowsWhatHasGrown) {
  GrowthForecast growth;
  EXPECT_FALSE(growth.is_known());
  EXPECT_GT(growth.After(1000, 9), 2000) << "the default growth";
  EXPECT_EQ(growth.After(1000, 0), 1000);
  for (const Index after : {1200, 1300, 1400}) growth.Observe(1000, after);
  EXPECT_FALSE(growth.is_known());
  growth.Observe(1000, 1500);
  ASSERT_TRUE(growth.is_known());
  const double fall = (growth.After(1000, 1) / 1000 - 1) / 0.5;
  EXPECT_GT(fall, 0.7);
  EXPECT_LT(fall, 0.9);
  EXPECT_NEAR(growth.After(1000, 3), 1000 * (1 + 0.5 * fall) * (1 + 0.5 * fall * fall) * (1 + 0.5 * fall * fall * fall),
              1e-9);
}

TEST(GrowthForecast, FollowsTheAssumptionUntilItIsKnown) {
  for (const int changes : {1, 4, 10}) {
    GrowthForecast growth = GrowthForecast::Assuming(4.5, changes);
    EXPECT_NEAR(growth.After(1000, changes), 4500, 1e-6);
    growth.Observe(100, 200);
    EXPECT_LT(growth.After(1000, changes - 1), 4500) << "one of them has passed";
  }
  EXPECT_NEAR(GrowthForecast::Assuming(1, 10).After(1000, 10), 1000, 1e-6);
}

TEST(ExpectedGrowth, RisesWithThePixelsPerPoint) {
  Scene scene;
  scene.views.resize(4);
  for (View& view : scene.views) view.camera.width = 100, view.camera.height = 50;
  scene.views[3].role = ViewRole::kTest;
  scene.points.positions.resize(150);
  EXPECT_NEAR(ExpectedGrowth(scene), 0.035 * std::pow(100, 0.94), 1e-12) << "of the training views";
  scene.points.positions.clear();
  EXPECT_TRUE(std::isfinite(ExpectedGrowth(scene)));
  scene.points.positions.resize(1'000'000);
  EXPECT_EQ(ExpectedGrowth(scene), 1);
}

TEST(GrowthForecast, OfAModelThatDoesNotGrow) {
  GrowthForecast growth;
  for (int k = 0; k < 4; ++k) growth.Observe(1000, k == 1 ? 900 : 1000);
  EXPECT_TRUE(growth.is_known());
  EXPECT_EQ(growth.After(1000, 5), 1000);
}

TEST(IterationTimer, FirstIterationsDoNotCount) {
  IterationTimer timer;
  EXPECT_FALSE(timer.is_known());
  timer.Observe(true, 100, 10);
  EXPECT_FALSE(timer.is_known());
  timer.Observe(true, 100, 0.1);
  EXPECT_TRUE(timer.is_known());
  EXPECT_DOUBLE_EQ(timer.Seconds(true, 100), 0.1);
  EXPECT_GT(timer.Seconds(true, 200), 0.15) << "more Gaussians take longer";
  EXPECT_LE(timer.Seconds(true, 200), 0.2);
  EXPECT_GT(timer.Seconds(false, 100), 0.1) << "the usual ratio";
  timer.SetFullMinusCoarse(0.2);
  EXPECT_DOUBLE_EQ(timer.Seconds(false, 100), 0.3) << "foreseen";
  timer.Observe(false, 100, 10);
  timer.Observe(false, 100, 0.4);
  EXPECT_DOUBLE_EQ(timer.Seconds(false, 100), 0.4) << "measured";
}

TEST(IterationTimer, FollowsIterationsThatBecomeSlower) {
  IterationTimer timer;
  for (int it = 0; it < 100; ++it) timer.Observe(false, 100, 0.1);
  for (int it = 0; it < 100; ++it) timer.Observe(false, 100, 0.3);
  EXPECT_NEAR(timer.Seconds(false, 100), 0.3, 0.002);
}

TEST(IterationTimer, LeavesOutWhatOtherWorkHeldUp) {
  IterationTimer timer;
  for (int it = 0; it < 100; ++it) timer.Observe(false, 100, it % 20 == 7 ? 50 : 0.1);
  EXPECT_NEAR(timer.Seconds(false, 100), 0.1, 1e-6);
}

TEST(IterationTimer, OfChangesIsInProportionToTheGaussians) {
  IterationTimer timer;
  EXPECT_EQ(timer.ChangeSeconds(1000), 0);
  timer.ObserveChange(1000, 2);
  timer.ObserveChange(3000, 6);
  EXPECT_DOUBLE_EQ(timer.ChangeSeconds(5000), 10);
}

// `done` of the stage, with 100 Gaussians of at most 150.
StageProgress After(double done, bool has_coarse_views = true) {
  return {.span = {done, done}, .gaussians = 100, .max_gaussians = 150, .has_coarse_views = has_coarse_views};
}

TEST(ForecastStage, AddsUpWhatIsLeft) {
  IterationTimer timer;
  for (int it = 0; it < 3; ++it) timer.Observe(true, 100, 1), timer.Observe(false, 100, 3);
  TrainOptions options;
  options.adam.half_resolution_until = 0.5;
  options.pruning = PruningOptions::None();
  DensityOptions& density = options.density;
  density.enabled = false;
  const auto ahead = [&](double done, bool has_coarse_views = true) {
    return ForecastStage(timer, {}, TrainingSchedule(options), After(done, has_coarse_views));
  };
  EXPECT_NEAR(ahead(0).seconds, 2, 0.03);
  EXPECT_NEAR(ahead(0.25).seconds, (1 + 2 * 3) / 3.0, 0.03);
  EXPECT_NEAR(ahead(0.5).seconds, 3, 1e-12);
  EXPECT_NEAR(ahead(0, false).seconds, 3, 1e-12) << "images too small for half resolution";
  EXPECT_NEAR(ahead(0).full_seconds, 3, 1e-12);
  EXPECT_EQ(ahead(0).gaussians, 100);

  const double without_growth = ahead(0.1).seconds;
  density.enabled = true;
  density.begin = density.every = 0.1, density.end = 0.3;
  GrowthForecast growth;
  growth.Observe(90, 100);
  const RemainingWork growing = ForecastStage(timer, growth, TrainingSchedule(options), After(0.1));
  EXPECT_EQ(growing.gaussians, 150) << "the cap";
  EXPECT_GT(growing.seconds, 1.1 * without_growth);

  options.pruning.aic_weight = 2;
  const RemainingWork pruned = ForecastStage(timer, growth, TrainingSchedule(options), After(0.1));
  EXPECT_EQ(pruned.gaussians, 112) << "75 % of 150, rounded down";
  EXPECT_EQ(pruned.most_gaussians, 150);
  EXPECT_LT(pruned.seconds, growing.seconds);
}

TEST(ForecastStage, JudgesInAPartOfALimitedTime) {
  IterationTimer timer;
  for (int it = 0; it < 3; ++it) timer.Observe(true, 100, 0.1), timer.Observe(false, 100, 0.1);
  TrainOptions options;
  options.density.enabled = false;
  constexpr double kViews = 20;
  const auto changes = [&] {
    return ForecastStage(timer, {}, TrainingSchedule(options), After(0), kViews).change_seconds;
  };
  const double all = changes();
  EXPECT_GT(all, 8 * kViews * 0.1 * 0.6) << "at least eight rounds of pruning";
  options.time_limit = 2 * all;
  EXPECT_DOUBLE_EQ(changes(), kScoringFraction * 2 * all);
  options.time_limit = 10 * all;
  EXPECT_DOUBLE_EQ(changes(), all);
  options.time_limit = 2 * all, options.pruning.keep_fraction = 0.5;
  EXPECT_GT(changes(), kScoringFraction * 2 * all) << "a requested number of Gaussians is not limited by time";
}

TEST(ForecastStage, CountsScoringBeforeGrowth) {
  IterationTimer timer;
  for (int it = 0; it < 3; ++it) timer.Observe(true, 100, 0.1), timer.Observe(false, 100, 0.1);
  TrainOptions options;
  constexpr double kViews = 20;
  const auto changes = [&](bool densifies) {
    options.density.enabled = densifies;
    const StageProgress start{.span = {0, 0}, .gaussians = 100, .max_gaussians = 100};  // no room to grow
    return ForecastStage(timer, {}, TrainingSchedule(options), start, kViews).change_seconds;
  };
  // At 0.1, 0.15 ... 0.55. At 0.6, Gaussians are pruned in both cases.
  EXPECT_NEAR(changes(true) - changes(false), 10 * kViews * 0.1, 1e-9);
  options.pruning.keep_fraction = 0.5;
  EXPECT_NEAR(changes(true) - changes(false), 0, 1e-9);
}

TEST(RemainingWork, KeepsTimeForChangesButNotAllOfIt) {
  const RemainingWork ahead{.seconds = 0.1, .change_seconds = 4};
  EXPECT_DOUBLE_EQ(ahead.IterationsIn(10), 60);
  EXPECT_DOUBLE_EQ(ahead.IterationsIn(4.8), 12) << "changes take at most three quarters of the time";
  EXPECT_LT(ahead.IterationsIn(-1), 0);
}

// Simulated clock: iterations take 1 at half size, 3 at full size and later 5. The stage ends in time, with the
// requested part at half resolution.
TEST(ForecastStage, EndsTheStageInTime) {
  constexpr double kTime = 5000;
  TrainOptions options;
  options.adam.half_resolution_until = 0.5;
  DensityOptions& density = options.density;
  density.enabled = false;
  IterationTimer timer;
  double clock = 0, done = 0;
  int coarse = 0, fine = 0;
  while (done < 1) {
    double left = 1e300;
    if (timer.is_known())
      left = (kTime - clock) / ForecastStage(timer, {}, TrainingSchedule(options), After(done)).seconds;
    done += (1 - done) / std::max(1.0, left);
    const bool is_coarse = done <= options.adam.half_resolution_until;
    ++(is_coarse ? coarse : fine);
    const double seconds = is_coarse ? 1 : fine < 500 ? 3 : 5;
    timer.Observe(is_coarse, 100, seconds);
    clock += seconds;
    ASSERT_LT(clock, 2 * kTime);
  }
  EXPECT_NEAR(clock, kTime, 6);
  EXPECT_GT(coarse, 900);
  EXPECT_GT(fine, 600);
}

}  // namespace

}  // namespace vesta::gs
