// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/settings/training_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "splatting/adam/adam_options.h"
#include "splatting/train/trainer.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

TEST(FitToScene, GivesManyViewsMoreIterations) {
  EXPECT_EQ(IterationsFor(1), 4000);
  EXPECT_EQ(IterationsFor(20), 4000);
  EXPECT_EQ(IterationsFor(264), 20064);
  TrainOptions options = PresetOptions("balanced");
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 20064);
  options.adam.iterations_scale = 0.25;
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 5016);
  options.adam.batch_size = 4;
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 5016) << "counted in views, not iterations";
  options.adam.iterations = 7;
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 7);
  options.adam.iterations.reset();
  options.time_limit = 60;
  EXPECT_EQ(FitToScene(options, 264).adam.iterations, 10000000) << "the time limit ends it";
  EXPECT_EQ(FitToScene(options, 20).sh_degree, 2);
  EXPECT_EQ(FitToScene(options, 264).sh_degree, 3);
}

constexpr int kIterations = 1000;

IterationPlan PlanOf(const TrainingSchedule& schedule, int iteration) {
  return schedule.At({(iteration - 1.0) / kIterations, 1.0 * iteration / kIterations});
}

int Count(const TrainingSchedule& schedule, const std::function<bool(const IterationPlan&)>& is_so) {
  int count = 0;
  for (int it = 1; it <= kIterations; ++it) count += is_so(PlanOf(schedule, it)) ? 1 : 0;
  return count;
}

TEST(TrainingSchedule, HasAsManyOfEachEventAsTheOptionsSay) {
  const TrainOptions options;
  const TrainingSchedule schedule(options);
  EXPECT_EQ(Count(schedule, [](const IterationPlan& p) { return p.is_coarse; }), 500);
  EXPECT_EQ(Count(schedule, [](const IterationPlan& p) { return p.is_recorded; }), 20);
  EXPECT_EQ(Count(schedule, [](const IterationPlan& p) { return p.observes; }), 600);
  EXPECT_EQ(Count(schedule, [](const IterationPlan& p) { return p.densifies; }), 11) << "0.1, 0.15 ... 0.6";
  EXPECT_EQ(Count(schedule, [](const IterationPlan& p) { return p.resets_opacity; }), 0);
  EXPECT_EQ(Count(schedule, [](const IterationPlan& p) { return p.shrinks_unseen; }), 19) << "0.05, 0.1 ... 0.95";
  EXPECT_EQ(Count(schedule, [](const IterationPlan& p) { return p.lowers_sh_degrees; }), 1);
  EXPECT_EQ(Count(schedule, [](const IterationPlan& p) { return p.prunes; }), 8) << "0.625, 0.65 ... 0.8";
}

// By AIC, before each densification.
TEST(TrainingSchedule, PrunesBeforeGrowth) {
  TrainOptions options;
  const auto prunes = [](const IterationPlan& p) { return p.prunes_before_growth; };
  const auto count = [&] { return Count(TrainingSchedule(options), prunes); };
  EXPECT_EQ(count(), 11) << "0.1, 0.15 ... 0.6";
  EXPECT_EQ(
      Count(TrainingSchedule(options), [&](const IterationPlan& p) { return prunes(p) && (!p.densifies || p.prunes); }),
      0)
      << "once per iteration";
  options.pruning.keep_fraction = 0.5;
  EXPECT_EQ(count(), 0);
  options = {};
  options.pruning.aic_weight = 0;
  EXPECT_EQ(count(), 0);
  options = {};
  options.density.enabled = false;
  EXPECT_EQ(count(), 0);
  EXPECT_EQ(Count(TrainingSchedule(options), [](const IterationPlan& p) { return p.prunes; }), 9)
      << "0.6, 0.625 ... 0.8";
}

// From the first to the last pruning. Pruning before growth begins one interval of density control before the first
// growth, so that it has some time.
TEST(TrainingSchedule, ScoringFractionIsOfThePeriodWithPruning) {
  TrainOptions options;
  const auto fraction = [&](double done) {
    return TrainingSchedule(options).At({done - 0.001, done}).scoring_fraction;
  };
  EXPECT_NEAR(fraction(0.05), 0, 1e-12);
  EXPECT_NEAR(fraction(0.1), 0.05 / 0.75, 1e-12);
  EXPECT_NEAR(fraction(0.425), 0.5, 1e-12);
  EXPECT_EQ(fraction(0.8), 1);
  EXPECT_EQ(fraction(0.9), 1);
  options.density.enabled = false;
  EXPECT_EQ(fraction(0.6), 0);
  EXPECT_NEAR(fraction(0.65), 0.25, 1e-12);
  options.density.enabled = true, options.pruning.keep_fraction = 0.5;
  EXPECT_NEAR(fraction(0.7), 0.5, 1e-12);
}

TEST(TrainingSchedule, ResetsOpacityOnlyWhileDensityControlObserves) {
  TrainOptions options;
  options.density.opacity_reset_every = 0.25;
  const TrainingSchedule schedule(options);
  EXPECT_TRUE(PlanOf(schedule, 250).resets_opacity);
  EXPECT_TRUE(PlanOf(schedule, 500).resets_opacity);
  EXPECT_FALSE(PlanOf(schedule, 750).resets_opacity);
}

TEST(TrainingSchedule, BringsBandsLaterWhereExposuresAreFound) {
  TrainOptions options;
  const TrainingSchedule schedule(options);
  EXPECT_EQ(PlanOf(schedule, 80).max_sh_degree, 0);
  EXPECT_EQ(PlanOf(schedule, 81).max_sh_degree, 1);
  EXPECT_EQ(PlanOf(schedule, kIterations).max_sh_degree, 3);
  options.cameras.refine = CameraChoice::kPose;
  EXPECT_EQ(PlanOf(schedule, 81).max_sh_degree, 1);
  options.cameras.refine = CameraChoice::kPoseAndExposure;
  EXPECT_EQ(PlanOf(schedule, 160).max_sh_degree, 0);
  EXPECT_EQ(PlanOf(schedule, 161).max_sh_degree, 1);
}

TEST(TrainingSchedule, LetsRatesFallByTheirFactor) {
  TrainOptions options;
  options.adam.lr_scale = 4, options.adam.lr_final_ratio = 0.25;
  const TrainingSchedule schedule(options);
  EXPECT_DOUBLE_EQ(schedule.At({0, 0.1}).lr_factor, 4);
  EXPECT_DOUBLE_EQ(schedule.At({0.5, 0.6}).lr_factor, 2);
}

// The length of the stage is given in views.
TEST(ViewsAnIteration, MakeFewerIterations) {
  AdamOptions adam;
  adam.iterations = 20;
  const auto iterations = [&](int views) {
    adam.batch_size = views;
    return NumIterations(adam);
  };
  EXPECT_EQ(iterations(1), 20);
  EXPECT_EQ(iterations(4), 5);
  EXPECT_EQ(iterations(8), 3) << "the last one is a full batch of eight too";
  EXPECT_EQ(iterations(100), 1);
  adam.iterations = 0;
  EXPECT_EQ(iterations(4), 0);

  TrainOptions options = test::ShortTraining(40, 0);
  options.adam.batch_size = 4;
  EXPECT_EQ(Train(test::TrainingScene(), options, {}, {}).history.back().iteration, 10);
}

TEST(ViewsAnIteration, AreNoMoreThanThereAre) {
  const Scene scene = test::TrainingScene();
  const auto training = [&](int views) {
    TrainOptions options = test::ShortTraining(40, 0);
    options.adam.batch_size = views;
    return [&scene, options] { Train(scene, options, {}, {}); };
  };
  ASSERT_EQ(NumTrainingViews(scene), 10);
  EXPECT_NO_THROW(training(10)());
  EXPECT_THAT(training(11), ThrowsError(kBadArgument, "adam.batch_size=11", "10"));
  EXPECT_THAT(training(0), ThrowsError(kBadArgument, "adam.batch_size=0", "1"));
}

}  // namespace

}  // namespace vesta::gs
