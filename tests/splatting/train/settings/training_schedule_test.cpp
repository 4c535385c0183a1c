// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <functional>

#include "splatting/train/settings/training_plan.h"

namespace vesta::gs {
namespace {

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
  EXPECT_EQ(Count(schedule, [](const IterationPlan& p) { return p.prunes_unseen; }), 2) << "0.6 and 0.8";
  EXPECT_EQ(Count(schedule, [](const IterationPlan& p) { return p.lowers_sh_degrees; }), 1);
  EXPECT_EQ(Count(schedule, [](const IterationPlan& p) { return p.prunes; }), 9) << "0.6, 0.625 ... 0.8";
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
  EXPECT_EQ(PlanOf(schedule, 80).most_sh_degree, 0);
  EXPECT_EQ(PlanOf(schedule, 81).most_sh_degree, 1);
  EXPECT_EQ(PlanOf(schedule, kIterations).most_sh_degree, 3);
  options.cameras.refine = CameraChoice::kPose;
  EXPECT_EQ(PlanOf(schedule, 81).most_sh_degree, 1);
  options.cameras.refine = CameraChoice::kPoseAndExposure;
  EXPECT_EQ(PlanOf(schedule, 160).most_sh_degree, 0);
  EXPECT_EQ(PlanOf(schedule, 161).most_sh_degree, 1);
}

TEST(TrainingSchedule, LetsRatesFallByTheirFactor) {
  TrainOptions options;
  options.adam.rate_factor = 4, options.adam.rate_decay = 0.25;
  const TrainingSchedule schedule(options);
  EXPECT_DOUBLE_EQ(schedule.At({0, 0.1}).lr_factor, 4);
  EXPECT_DOUBLE_EQ(schedule.At({0.5, 0.6}).lr_factor, 2);
}

}  // namespace
}  // namespace vesta::gs
