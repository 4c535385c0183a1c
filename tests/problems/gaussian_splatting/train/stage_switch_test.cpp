#include "problems/gaussian_splatting/train/stage_switch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace vesta::gs {
namespace {

constexpr Index kViews = 10;

TrainOptions Automatic() {
  TrainOptions options;
  options.adam.iterations = 1000;
  options.adam.switch_to_lm = SwitchToLm::kAuto;
  options.adam.coarse_part = 0.5;
  options.adam.cooldown = 0.1;
  options.density.end = 0.6;
  options.lm.min_gain = 0.01;
  return options;
}

// The iteration after which a stage ends whose iterations cost so much.
int EndWith(const TrainOptions& options, const std::function<double(int)>& cost) {
  StageSwitch stage_switch(options, kViews);
  int it = 0;
  while (it < stage_switch.end()) {
    ++it;
    stage_switch.Observe(it, cost(it));
  }
  return it;
}

// Falls by such a part an iteration.
std::function<double(int)> Falling(double part) {
  return [part](int it) { return std::pow(1 - part, it); };
}

// What an iteration must lower the cost by for Adam to go on.
double LeastFall(const TrainOptions& options) { return options.lm.min_gain / LmWork(options.lm, kViews); }

TEST(StageSwitch, FixedWhateverTheCost) {
  TrainOptions options = Automatic();
  options.adam.switch_to_lm = SwitchToLm::kFixed;
  EXPECT_EQ(EndWith(options, Falling(0)), 1000);
}

TEST(StageSwitch, LeavesAdamWhereLmGainsMoreForItsWork) {
  const TrainOptions options = Automatic();
  EXPECT_EQ(EndWith(options, Falling(1.2 * LeastFall(options))), 1000);
  // Two windows of 50 iterations after the first 600, then a tenth of it all to cool down in.
  EXPECT_EQ(EndWith(options, Falling(0.8 * LeastFall(options))), static_cast<int>(std::ceil(700 / 0.9)));
}

TEST(StageSwitch, OnlyAfterDensificationAndCoarseViews) {
  TrainOptions options = Automatic();
  const auto stalled = Falling(0);
  options.adam.coarse_part = 0.7;
  EXPECT_EQ(EndWith(options, stalled), static_cast<int>(std::ceil(800 / 0.9)));
  options.adam.coarse_part = 0;
  options.density.enabled = false;
  EXPECT_EQ(EndWith(options, stalled), static_cast<int>(std::ceil(100 / 0.9)));
  // The cooldown of the whole stage begins sooner.
  options.adam.coarse_part = 0.95;
  EXPECT_EQ(EndWith(options, stalled), 1000);
}

TEST(StageSwitch, WithoutLmOrALeastGainThereIsNothingToSwitchTo) {
  TrainOptions options = Automatic();
  options.lm.iterations = 0;
  EXPECT_EQ(EndWith(options, Falling(0)), 1000);
  options = Automatic();
  options.lm.min_gain = 0;
  EXPECT_EQ(EndWith(options, Falling(1e-6)), 1000);
}

// Views that differ do not count as progress nor hide it: each has its turn once in an epoch.
TEST(StageSwitch, ComparesWholeEpochs) {
  const TrainOptions options = Automatic();
  const auto uneven = [&](double fall) {
    return [fall](int it) { return (1 + 0.9 * (it * 7 % kViews)) * Falling(fall)(it); };
  };
  EXPECT_EQ(EndWith(options, uneven(1.3 * LeastFall(options))), 1000);
  EXPECT_LT(EndWith(options, uneven(0.7 * LeastFall(options))), 1000);
}

TEST(StageSwitch, GoesOnAfterAStepBack) {
  const TrainOptions options = Automatic();
  StageSwitch stage_switch(options, kViews);
  for (int it = 1; it <= 640; ++it) stage_switch.Observe(it, 1);
  for (int it = 601; it < 700; ++it) stage_switch.Observe(it, 1);
  EXPECT_EQ(stage_switch.end(), 1000);
  stage_switch.Observe(700, 1);
  EXPECT_LT(stage_switch.end(), 1000);
}

TEST(LmWork, GrowsWithWhatIsMeasured) {
  LmStageOptions lm;
  const double whole = LmWork(lm, kViews);
  EXPECT_DOUBLE_EQ(LmWork(lm, 2 * kViews), 2 * whole);
  lm.batch_size = 5;
  EXPECT_DOUBLE_EQ(LmWork(lm, kViews), whole / 2);
  lm.batches = 4;
  EXPECT_DOUBLE_EQ(LmWork(lm, kViews), whole);
  lm = {};
  lm.jacobian = JacobianKind::kRecompute;
  EXPECT_LT(LmWork(lm, kViews), whole);
  lm = {};
  lm.pcg_iterations *= 2;
  EXPECT_GT(LmWork(lm, kViews), whole);
}

}  // namespace
}  // namespace vesta::gs
