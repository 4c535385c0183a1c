// SPDX-License-Identifier: Apache-2.0
#include "splatting/pruning/harmonics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/pruning/scoring_views.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs {
namespace {

constexpr int kDegree = 2;

// Differs from its photographs. Gaussians 0, 3, 6, ... have one colour in all directions, the others very different
// ones.
struct Fit {
  Scene scene = test::RingOfCameras(10, 48, 36, true);
  SplatModel model = test::RandomModel(30, kDegree, 3);

  Fit() {
    for (int a = splat::kSh + 3; a < model.num_attributes(); ++a) {
      for (Index i = 0; i < model.count; ++i) model.attribute(a)[i] *= i % 3 == 0 ? 0.0f : 3.0f;
    }
    test::RenderTruth(test::Perturbed(model, 0.03, 4), 0, &scene);
  }
  ScoringViews MakeScoringViews() const { return TrainingViewsOf(scene, {0, 0, 0}); }
  ShRemovalCost Measure() const { return ShRemovalCost(ToKernelModel(model), MakeScoringViews()); }
  double Cost() const { return MeasureRemovalCost(ToKernelModel(model), MakeScoringViews()).loss; }
  void Lower(const ShRemovalCost& removal, Index i, int degree) {
    for (int a = 0; a < model.num_attributes() - splat::kSh; ++a) {
      model.attribute(splat::kSh + a)[i] = a < 3 * ShCoefficients(degree) ? removal.Coefficient(i, degree, a) : 0;
    }
  }
};

TEST(ShRemovalCost, IsTheRiseOfTheCostAtTheLowerDegree) {
  const Fit fit;
  const ShRemovalCost removal = fit.Measure();
  EXPECT_NEAR(removal.loss(), fit.Cost(), 1e-6 * fit.Cost());
  int compared = 0;
  for (Index i = 0; i < fit.model.count; ++i) {
    for (int degree = 0; degree < kDegree; ++degree) {
      Fit lower = fit;
      lower.Lower(removal, i, degree);
      const double rise = lower.Cost() - removal.loss();
      // SSIM is only approximated by a quadratic.
      EXPECT_NEAR(removal.Rise(i, degree), rise, 0.3 * std::abs(rise) + 5e-4 * removal.loss()) << i << " " << degree;
      compared += std::abs(rise) > 0.003 * removal.loss() ? 1 : 0;
    }
  }
  EXPECT_GT(compared, 10) << "that matter";
}

TEST(ShRemovalCost, StandsInBetterThanLeavingOut) {
  const Fit fit;
  const ShRemovalCost removal = fit.Measure();
  double stood_in = 0, left_out = 0;
  for (Index i = 1; i < fit.model.count; i += 3) {
    Fit lower = fit;
    for (int a = splat::kSh + 3; a < fit.model.num_attributes(); ++a) lower.model.attribute(a)[i] = 0;
    left_out += lower.Cost() - removal.loss();
    stood_in += removal.Rise(i, 0);
  }
  EXPECT_LT(stood_in, 0.9 * left_out);
}

TEST(ShRemovalCost, WhatLooksAlikeFromAllSidesLosesNothing) {
  const Fit fit;
  const ShRemovalCost removal = fit.Measure();
  for (Index i = 0; i < fit.model.count; i += 3) {
    for (int degree = 0; degree < kDegree; ++degree)
      EXPECT_NEAR(removal.Rise(i, degree), 0, 1e-5 * removal.loss()) << i;
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(removal.Coefficient(i, 0, c), fit.model.attribute(splat::kSh + c)[i], 1e-5) << i;
    }
  }
}

// From one side, the SH basis functions are indistinguishable.
TEST(ShRemovalCost, SeenFromOneSideTheLowestStandsInForAll) {
  Fit fit;
  View only = fit.scene.views[1];
  ASSERT_TRUE(only.is_trained());
  fit.scene.views = {only};
  const ShRemovalCost removal = fit.Measure();
  const std::vector<double> alone = MeasureRemovalCost(ToKernelModel(fit.model), fit.MakeScoringViews()).rise;
  double most = 0;
  for (const double rise : alone) most = std::max(most, std::abs(rise));
  for (Index i = 0; i < fit.model.count; ++i) EXPECT_NEAR(removal.Rise(i, 0), 0, 0.01 * most) << i;
}

TEST(DegreesByAic, FollowTheAicWeight) {
  const Fit fit;
  const ShRemovalCost removal = fit.Measure();
  const auto degrees = [&](double aic_weight) { return DegreesByAic(ToKernelModel(fit.model), removal, aic_weight); };
  const std::vector<std::uint8_t> cheap = degrees(1e-3), dear = degrees(1e9);
  for (Index i = 0; i < fit.model.count; i += 3) EXPECT_EQ(cheap[static_cast<std::size_t>(i)], 0) << i;
  EXPECT_GT(std::ranges::count(cheap, kDegree), 5);
  EXPECT_EQ(std::ranges::count(dear, 0), fit.model.count);
  std::vector<std::uint8_t> last = degrees(0);
  for (const double aic_weight : {0.01, 0.1, 1.0, 10.0, 100.0}) {
    const std::vector<std::uint8_t> now = degrees(aic_weight);
    for (std::size_t i = 0; i < now.size(); ++i) EXPECT_LE(now[i], last[i]) << aic_weight << " " << i;
    last = now;
  }
}

}  // namespace
}  // namespace vesta::gs
