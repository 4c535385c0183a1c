// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/pruning/scoring_views.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs {
namespace {

constexpr std::array<double, 3> kBackground = {0, 0, 0};

// Differs from its photographs; every fifth is a test view.
struct Fit {
  Scene scene = test::RingOfCameras(10, 48, 36, true);
  SplatModel model = test::RandomModel(40, 1, 3);

  Fit() { test::RenderTruth(test::Perturbed(model, 0.03, 4), 0, &scene); }
  RemovalCost Measure() const { return MeasureRemovalCost(ToKernelModel(model), TrainingViewsOf(scene, kBackground)); }
};

TEST(RemovalCost, CostIsThatOfTheTrainingViews) {
  Fit fit;
  Renderer renderer(kBackground, NearPlane(fit.scene));
  double values = 0;
  for (const View& view : fit.scene.views) {
    if (view.is_trained()) values += 3.0 * view.camera.width * view.camera.height;
  }
  const double cost = fit.Measure().loss;
  EXPECT_NEAR(cost, values * renderer.Evaluate(fit.model, fit.scene).cost, 1e-5 * cost);
  for (View& view : fit.scene.views) {
    if (!view.is_trained()) view.image.rgb.assign(view.image.rgb.size(), 0.5f);
  }
  EXPECT_EQ(fit.Measure().loss, cost) << "test views do not count";
}

TEST(RemovalCost, IsTheRiseOfTheCostWithoutIt) {
  Fit fit;
  const RemovalCost removal = fit.Measure();
  float* logit = fit.model.attribute(splat::kOpacity);
  int compared = 0;
  for (Index i = 0; i < fit.model.count; ++i) {
    const float before = std::exchange(logit[i], -100.0f);
    const double rise = fit.Measure().loss - removal.loss;
    logit[i] = before;
    const double said = removal.rise[static_cast<std::size_t>(i)];
    // SSIM is only approximated by a quadratic, and most rises are large.
    EXPECT_NEAR(said, rise, 0.35 * std::abs(rise) + 0.002 * removal.loss) << i;
    compared += std::abs(rise) > 0.01 * removal.loss ? 1 : 0;
  }
  EXPECT_GT(compared, 20) << "that matter";
}

// Masks over the right half of each view, or all of it.
TEST(RemovalCost, PixelsThatDoNotCountHaveNoSay) {
  Fit fit;
  const RemovalCost whole = fit.Measure();
  const auto mask_from = [&](int column) {
    for (View& view : fit.scene.views) {
      view.image.mask.clear();
      for (int i = 0; i < 48 * 36; ++i) view.image.mask.push_back(i % 48 < column ? 1 : 0);
    }
  };
  mask_from(48);
  EXPECT_EQ(fit.Measure().rise, whole.rise);
  mask_from(24);
  const RemovalCost half = fit.Measure();
  EXPECT_LT(half.loss, 0.8 * whole.loss);
  EXPECT_EQ(half.values, whole.values / 2);
  float* logit = fit.model.attribute(splat::kOpacity);
  for (Index i = 0; i < 10; ++i) {
    const float before = std::exchange(logit[i], -100.0f);
    const double rise = fit.Measure().loss - half.loss;
    logit[i] = before;
    EXPECT_NEAR(half.rise[static_cast<std::size_t>(i)], rise, 0.35 * std::abs(rise) + 0.002 * half.loss) << i;
  }
  mask_from(0);
  const RemovalCost nothing = fit.Measure();
  EXPECT_EQ(nothing.loss, 0);
  for (const double rise : nothing.rise) EXPECT_EQ(rise, 0);
}

TEST(RemovalCost, TheLargestRiseIsThatOfOneView) {
  const Fit fit;
  const RemovalCost removal = fit.Measure();
  const ScoringViews all = TrainingViewsOf(fit.scene, {0, 0, 0});
  std::vector<double> largest(removal.rise.size());
  for (const View* view : all.views) {
    ScoringViews one = all;
    one.views = {view};
    const RemovalCost alone = MeasureRemovalCost(ToKernelModel(fit.model), one);
    for (std::size_t i = 0; i < largest.size(); ++i) largest[i] = std::max(largest[i], alone.rise[i]);
  }
  EXPECT_EQ(removal.largest_rise, largest);
}

TEST(RemovalCost, WhatNoViewShowsHasNone) {
  Fit fit;
  fit.model.attribute(splat::kMean + 1)[7] = 1000;
  const RemovalCost removal = fit.Measure();
  EXPECT_EQ(removal.rise[7], 0);
  EXPECT_NE(removal.rise[8], 0);
}

}  // namespace
}  // namespace vesta::gs
