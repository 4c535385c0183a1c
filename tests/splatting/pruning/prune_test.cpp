// SPDX-License-Identifier: Apache-2.0
#include "splatting/pruning/prune.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/pruning/pruning_options.h"
#include "splatting/pruning/scoring_views.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

// Photographs of a model before ten nearly invisible Gaussians were added.
struct Padded {
  static constexpr Index kNeeded = 30, kAll = 40;
  Scene scene = test::RingOfCameras(8, 48, 36, true);
  SplatModel model = test::RandomModel(kAll, 0, 3);

  Padded() {
    float* logit = model.attribute(splat::kOpacity);
    for (Index i = kNeeded; i < kAll; ++i) logit[i] = -20;
    test::RenderTruth(model, 0, &scene);
    for (Index i = kNeeded; i < kAll; ++i) logit[i] = -4;
  }
  ScoringViews MakeScoringViews() const { return TrainingViewsOf(scene, {0, 0, 0}); }
  PruneResult PruneTo(const PruneGoal& goal) const { return Prune(model, MakeScoringViews(), {.goal = goal}); }
};

TEST(SelectToKeep, AreThoseTheViewsMiss) {
  const Padded padded;
  const std::vector<Index> kept =
      SelectToKeep(ToKernelModel(padded.model), padded.MakeScoringViews(), true, Padded::kNeeded);
  ASSERT_EQ(kept.size(), 30U);
  for (Index i = 0; i < Padded::kNeeded; ++i) EXPECT_EQ(kept[static_cast<std::size_t>(i)], i);
}

TEST(SelectToKeep, WhatNoViewShowsGoesFirst) {
  Padded padded;
  // Large, opaque, and outside all images.
  padded.model.attribute(splat::kMean + 1)[4] = 4;
  for (int k = 0; k < 3; ++k) padded.model.attribute(splat::kLogScale + k)[4] = -1;
  const std::vector<Index> kept =
      SelectToKeep(ToKernelModel(padded.model), padded.MakeScoringViews(), true, Padded::kAll - 1);
  EXPECT_THAT(kept, testing::Not(testing::Contains(4)));
}

TEST(SelectToKeep, AreAsManyAsAskedForInTheirOrder) {
  const Padded padded;
  const std::vector<Index> kept =
      SelectToKeep(ToKernelModel(padded.model), padded.MakeScoringViews(), true, Padded::kAll / 4);
  EXPECT_EQ(kept.size(), 10U);
  EXPECT_TRUE(std::ranges::is_sorted(kept));
}

TEST(SupportedRises, LeaveOutTheLargestRiseIfViewsOverlap) {
  RemovalCost removal{.rise = {6, 5, -1}, .largest_rise = {2, 3, 1}};  // s = 6 / 11
  EXPECT_THAT(SupportedRises(removal), testing::ElementsAre(4, 2, -2));
  removal = {.rise = {5, 5}, .largest_rise = {5, 4}};  // s = 0.1
  EXPECT_THAT(SupportedRises(removal), testing::ElementsAre(5 - 0.2 * 5, 5 - 0.2 * 4));
  removal = {.rise = {5, -1}, .largest_rise = {5, 0}};  // one view
  EXPECT_EQ(SupportedRises(removal), removal.rise);
  removal = {.rise = {-1}, .largest_rise = {1}};
  EXPECT_EQ(SupportedRises(removal), removal.rise);
}

TEST(KeepByAic, GoesByTheRiseForEachParameter) {
  Padded padded;
  for (View& view : padded.scene.views) {
    for (float& value : view.image.rgb) value = 0.9f * value + 0.05f;  // makes the cost positive
  }
  const splat::Model<float> model = ToKernelModel(padded.model);
  const auto kept = [&](double aic_weight, std::uint64_t round) {
    return KeepByAic(model, padded.MakeScoringViews(), aic_weight, 3, round);
  };
  const RemovalCost removal = MeasureRemovalCost(model, padded.MakeScoringViews());
  std::vector<double> rise = SupportedRises(removal);
  std::ranges::sort(rise);
  // Between the scores of the 10th and 11th Gaussian.
  const double aic_weight = (rise[9] + rise[10]) / 2 * removal.values / (removal.loss * padded.model.num_attributes());
  ASSERT_GT(aic_weight, 0);
  std::set<Index> gone;
  constexpr int kRounds = 20;
  double went = 0;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Index> left = kept(aic_weight, static_cast<std::uint64_t>(round));
    for (Index i = 0; i < Padded::kAll; ++i) {
      if (!std::ranges::binary_search(left, i)) gone.insert(i), went += 1.0 / kRounds;
    }
  }
  EXPECT_EQ(gone.size(), 10U);
  for (const Index i : gone) EXPECT_LE(SupportedRises(removal)[static_cast<std::size_t>(i)], rise[9]);
  EXPECT_NEAR(went, 4, 1) << "two fifths of them in each round";
  EXPECT_EQ(kept(aic_weight, 1), kept(aic_weight, 1));
  EXPECT_EQ(kept(1e12, 1).size(), 30U) << "at most a quarter per round";
  EXPECT_EQ(kept(-1e12, 1).size(), 40U);
}

// A model that stores SH bands which are not active yet.
TEST(KeepByAic, InactiveBandsCostNothing) {
  Padded padded;
  for (View& view : padded.scene.views) {
    for (float& value : view.image.rgb) value = 0.9f * value + 0.05f;
  }
  const SplatModel& low = padded.model;
  SplatModel high;
  high.Resize({.count = low.count, .sh_degree = 1});
  std::ranges::copy(low.data, high.data.begin());  // SH bands come last
  const splat::Model<float> inactive{high.data.data(), high.layout(), 0};
  const auto kept = [&](const splat::Model<float>& model, double aic_weight) {
    return KeepByAic(model, padded.MakeScoringViews(), aic_weight, 3, 1);
  };
  const RemovalCost removal = MeasureRemovalCost(ToKernelModel(low), padded.MakeScoringViews());
  std::vector<double> rise = SupportedRises(removal);
  std::ranges::sort(rise);
  bool depends = false;
  for (const std::size_t candidates : {3U, 8U, 12U}) {
    const double aic_weight = rise[candidates] * removal.values / (removal.loss * low.num_attributes());
    EXPECT_EQ(kept(inactive, aic_weight), kept(ToKernelModel(low), aic_weight));
    const double by_all = aic_weight * high.num_attributes() / low.num_attributes();
    depends |= kept(ToKernelModel(low), by_all) != kept(ToKernelModel(low), aic_weight);
  }
  EXPECT_TRUE(depends) << "on the number of attributes";
}

TEST(Prune, ToACount) {
  const Padded padded;
  const PruneResult result = padded.PruneTo({.count = Padded::kNeeded, .max_rise = {}});
  EXPECT_EQ(result.model.count, Padded::kNeeded);
  EXPECT_EQ(result.rounds, 1);
  EXPECT_LT(result.cost_after, 0.01 * result.cost_before) << "the added Gaussians are removed";
  for (int a = 0; a < padded.model.num_attributes(); ++a) {
    for (Index i = 0; i < Padded::kNeeded; ++i) {
      ASSERT_EQ(result.model.attribute(a)[i], padded.model.attribute(a)[i]) << "the needed ones are unchanged";
    }
  }
  EXPECT_EQ(padded.PruneTo({.count = 1000, .max_rise = {}}).model.data, padded.model.data);
  const PruneResult one = padded.PruneTo({.count = 0, .max_rise = {}});
  EXPECT_EQ(one.model.count, 1) << "one always remains";
  EXPECT_GT(one.rounds, 8) << "at most a quarter per round";
}

TEST(Prune, ToARise) {
  const Padded padded;
  Index last = Padded::kAll;
  // Other colours, so that the cost is positive.
  Padded other = padded;
  for (View& view : other.scene.views) {
    for (float& value : view.image.rgb) value = 0.9f * value + 0.05f;
  }
  for (const double rise : {0.01, 0.2, 3.0}) {
    const PruneResult result = other.PruneTo({.count = {}, .max_rise = rise});
    EXPECT_LE(result.cost_after, (1 + rise) * result.cost_before) << rise;
    EXPECT_LT(result.model.count, last) << rise;
    last = result.model.count;
  }
}

TEST(Prune, NeedsAJudge) {
  Padded padded;
  for (View& view : padded.scene.views) view.role = ViewRole::kTest;
  EXPECT_THAT([&] { padded.PruneTo({.count = 3, .max_rise = {}}); }, ThrowsError(kBadArgument));
}

TEST(PruningSchedule, TheSamePartGoesEachTime) {
  const PruningOptions pruning{.keep_fraction = 0.25, .begin = 0.5, .end = 0.7, .every = 0.1};
  constexpr int kIterations = 100;
  std::vector<std::pair<int, Index>> left;
  for (int it = 1; it <= kIterations; ++it) {
    const StageSpan span{(it - 1.0) / kIterations, 1.0 * it / kIterations};
    if (Prunes(pruning, span)) left.emplace_back(it, CountAfter(pruning, span, 1000));
  }
  EXPECT_EQ(left, (std::vector<std::pair<int, Index>>{{50, 1000}, {60, 500}, {70, 250}}));
  EXPECT_FALSE(Prunes(PruningOptions::None(), {0.69, 0.7})) << "not if disabled";
  EXPECT_TRUE(Prunes({.aic_weight = 2, .begin = 0.5, .end = 0.75}, {0.7, 0.75}));
  EXPECT_FALSE(Prunes({.aic_weight = 0}, {0.79, 0.8}));
  EXPECT_TRUE(LowersDegrees({}, {0.59, 0.6}));
  EXPECT_FALSE(LowersDegrees({}, {0.61, 0.62})) << "once";
  EXPECT_TRUE(LowersDegrees({.begin = 0, .every = 0.1}, {0.09, 0.1})) << "after the first interval";
  EXPECT_FALSE(LowersDegrees(PruningOptions::None(), {0.59, 0.6}));
  EXPECT_TRUE(Prunes({.keep_fraction = 0.5, .begin = 0, .end = 0.7, .every = 0.05}, {0.6, 0.8}))
      << "the last step crosses the end";
  EXPECT_THAT([] { ValidateCombination(PruningOptions{.keep_fraction = 0.5, .begin = 0.9}); },
              ThrowsError(kBadArgument, "pruning.begin=0.9", "pruning.end=0.8"));
  EXPECT_FALSE(Prunes({.keep_fraction = 0.5, .begin = 0, .end = 1, .every = 0.5}, {0.9, 1}))
      << "no training would follow";
  EXPECT_EQ(CountAfter({.keep_fraction = 1e-9}, {0.9, 1}, 1000), 1) << "always at least one";
}

TEST(PruningSchedule, UnseenGaussiansShrinkTwentyTimes) {
  constexpr int kIterations = 100;
  const auto shrinks = [](const PruningOptions& pruning) {
    std::vector<int> at;
    for (int it = 1; it <= kIterations; ++it) {
      if (ShrinksUnseen(pruning, {(it - 1.0) / kIterations, 1.0 * it / kIterations})) at.push_back(it);
    }
    return at;
  };
  // In the whole stage, but not in the last iteration.
  std::vector<int> expected;
  for (int it = 5; it < kIterations; it += 5) expected.push_back(it);
  EXPECT_EQ(shrinks({}), expected);
  EXPECT_THAT(shrinks({.shrink_unseen = false}), testing::IsEmpty());
  EXPECT_THAT(shrinks(PruningOptions::None()), testing::IsEmpty());
}

}  // namespace
}  // namespace vesta::gs
