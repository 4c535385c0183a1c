// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "splatting/train/forecast/forecast.h"
#include "tests/splatting/train/training_scene.h"

namespace vesta::gs {
namespace {

using ForecastKind = StagePlanner::ForecastKind;

// Constant number of Gaussians, all views at full resolution.
TrainOptions WithIterations(int iterations) {
  TrainOptions options;
  options.adam.iterations = iterations;
  options.adam.half_resolution_until = 0;
  options.density.enabled = false;
  options.pruning.aic_weight = options.pruning.sh_aic_weight = 0;
  return options;
}

struct OutlookOf {
  TrainOptions options;
  double seconds = 0;  // before the session started
  Scene scene = test::TrainingScene();
  TrainCallbacks callbacks = {};
  TrainingSession session{scene, options, seconds, callbacks};
  StagePlanner outlook{session};
};

// Two iterations: the first is ignored.
void Observe(StagePlanner& outlook, double seconds) {
  for (int k = 0; k < 2; ++k) outlook.ObserveIteration(false, 100, 1000, seconds);
}

TEST(StagePlanner, IterationsAreEqualPartsWhereTimeIsNotLimited) {
  OutlookOf of{WithIterations(40)};
  StagePlanner& outlook = of.outlook;
  Observe(outlook, 1e6);
  const StageProgress half{20, {19.0 / 40, 0.5}, 100};
  const StageSpan next = outlook.NextSpan(half);
  EXPECT_EQ(next.before, 0.5);
  EXPECT_EQ(next.after, 21.0 / 40);
  EXPECT_EQ(outlook.ExpectedIterations(half), 40);
}

// As after resuming with other iterations, or without the time limit.
TEST(StagePlanner, WhatIsLeftOfTheStageIsDividedAmongTheIterationsThatAreLeft) {
  OutlookOf of{WithIterations(40)};
  StagePlanner& outlook = of.outlook;
  StageProgress now{20, {0.7, 0.75}, 100};
  const StageSpan next = outlook.NextSpan(now);
  EXPECT_EQ(next.before, 0.75);
  EXPECT_DOUBLE_EQ(next.after, 0.75 + 0.25 / 20);
  while (!now.span.is_last() && now.iteration < 100) now.span = outlook.NextSpan(now), ++now.iteration;
  EXPECT_EQ(now.iteration, 40);
}

// Time is reserved for evaluations, so slightly fewer iterations fit.
TEST(StagePlanner, IterationsBecomeLargerPartsWhereTheyDoNotFit) {
  TrainOptions options = WithIterations(1000);
  options.time_limit = 150;
  OutlookOf of{options, 50};
  StagePlanner& outlook = of.outlook;
  const StageProgress half{20, {19.0 / 40, 0.5}, 100};
  EXPECT_EQ(outlook.ExpectedIterations(half), 0) << "before any iteration has been timed";
  EXPECT_TRUE(std::isnan(outlook.SecondsLeft(half)));
  Observe(outlook, 1);
  EXPECT_GT(outlook.SecondsLeft(half), 0);
  EXPECT_LE(outlook.SecondsLeft(half), 150);
  // Evaluation takes half the time per pixel of training; 14,400 pixels are evaluated.
  EXPECT_GT(outlook.ExpectedIterations(half), 20 + 85);
  EXPECT_LT(outlook.ExpectedIterations(half), 20 + 95);
  const StageSpan next = outlook.NextSpan(half);
  EXPECT_EQ(next.before, 0.5);
  EXPECT_GT(next.after, 0.5 + 0.5 / 100);
  EXPECT_LT(next.after, 0.5 + 0.5 / 70);
}

TEST(StagePlanner, ForetellsOnce) {
  const TrainOptions options = WithIterations(100);
  OutlookOf of{options, 50};
  StagePlanner& outlook = of.outlook;
  EXPECT_EQ(outlook.NextForecast(false), ForecastKind::kNothing) << "no iteration has been timed";
  Observe(outlook, 3);
  EXPECT_EQ(outlook.NextForecast(false), ForecastKind::kForecast);
  EXPECT_EQ(outlook.NextForecast(false), ForecastKind::kNothing) << "once";
  const StageProgress now{20, {0.19, 0.2}, 100};
  const RemainingWork ahead = outlook.Ahead(now);
  EXPECT_EQ(ahead.gaussians, 100);
  const Prediction told = outlook.MakeForecast(now, ahead, false, 7);
  EXPECT_EQ(told.mib, 7);
  // 80 iterations and four fifths of the history rows remain. Evaluation takes half the time per pixel.
  const double rows = std::ceil(0.8 * options.adam.evaluations);
  EXPECT_NEAR(told.seconds, told.at_seconds + 80 * 3 + rows * outlook.EvaluationSeconds(), 1e-6);
  EXPECT_DOUBLE_EQ(outlook.EvaluationSeconds(), 0.5 * 3e-3 * 12 * 40 * 30);
}

TEST(StagePlanner, IsNoGuessOnceItIsSeenHowTheGaussiansGrow) {
  OutlookOf of{WithIterations(100)};
  StagePlanner& outlook = of.outlook;
  Observe(outlook, 3);
  for (int change = 0; change < 4; ++change) outlook.ObserveGrowth(100, 150, 0.1);
  EXPECT_EQ(outlook.NextForecast(true), ForecastKind::kForecast);
}

}  // namespace
}  // namespace vesta::gs
