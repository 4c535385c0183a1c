// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/lm/view_batches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "kernels/core/check.h"

namespace vesta::gs {
namespace {

constexpr BatchChoice kChoices[] = {BatchChoice::kStrided, BatchChoice::kRandom};

std::vector<Index> All(const ViewBatches& batches) {
  std::vector<Index> all;
  for (int b = 0; b < batches.num_batches(); ++b) {
    EXPECT_TRUE(std::is_sorted(batches.views(b).begin(), batches.views(b).end()));
    all.insert(all.end(), batches.views(b).begin(), batches.views(b).end());
  }
  std::sort(all.begin(), all.end());
  return all;
}

TEST(ViewBatches, EveryChoiceDealsEachViewOnce) {
  constexpr Index kViews = 20;
  for (const BatchChoice choice : kChoices) {
    ViewBatches batches({.count = 3, .choice = choice, .seed = 5}, kViews);
    for (int turn = 0; turn < 3; ++turn) {
      batches.OnNewPoint(turn);
      ASSERT_EQ(batches.num_batches(), 3);
      const std::vector<Index> all = All(batches);
      ASSERT_EQ(all.size(), std::size_t{kViews});
      for (std::size_t v = 0; v < all.size(); ++v) EXPECT_EQ(all[v], static_cast<Index>(v));
      for (int b = 0; b < 3; ++b) EXPECT_NEAR(static_cast<double>(batches.views(b).size()), 20.0 / 3, 1);
      EXPECT_EQ(batches.scale(), 1);
    }
  }
}

TEST(ViewBatches, StridedTakesEveryNth) {
  const ViewBatches batches({.count = 3}, 8);
  EXPECT_EQ(batches.views(0), (std::vector<Index>{0, 3, 6}));
  EXPECT_EQ(batches.views(1), (std::vector<Index>{1, 4, 7}));
  EXPECT_EQ(batches.views(2), (std::vector<Index>{2, 5}));
}

TEST(ViewBatches, AStepOfFewerViewsGoesRoundThemAll) {
  constexpr Index kViews = 20;
  for (const BatchChoice choice : kChoices) {
    ViewBatches batches({.count = 2, .size = 3, .choice = choice, .seed = 1}, kViews);
    EXPECT_DOUBLE_EQ(batches.scale(), 20.0 / 6);
    std::set<Index> met;
    for (int turn = 0; turn < 40; ++turn) {
      batches.OnNewPoint(turn);
      ASSERT_EQ(batches.num_batches(), 2);
      const std::vector<Index> all = All(batches);
      ASSERT_EQ(std::set<Index>(all.begin(), all.end()).size(), 6u) << "without replacement";
      met.insert(all.begin(), all.end());
    }
    EXPECT_EQ(met.size(), std::size_t{kViews});
  }
}

// The paper's 25 to 70 images in up to 4 batches, with fewer images.
TEST(ViewBatches, CountAndSizeAreCutToTheViewsThereAre) {
  constexpr Index kViews = 17;
  const auto batches_of = [&](int count, int size) {
    return ViewBatches({.count = count, .size = size}, kViews).num_batches();
  };
  EXPECT_EQ(batches_of(4, 25), 1);
  EXPECT_EQ(batches_of(4, 8), 3);
  EXPECT_EQ(batches_of(4, 0), 4);
  EXPECT_EQ(batches_of(100, 0), 17);
  EXPECT_EQ(batches_of(100, 1), 17);
}

TEST(ViewBatches, DrawsDependOnSeedAndTurnAlone) {
  constexpr Index kViews = 20;
  ViewBatches a({.count = 2, .size = 4, .choice = BatchChoice::kRandom, .seed = 1}, kViews), b = a;
  ViewBatches other({.count = 2, .size = 4, .choice = BatchChoice::kRandom, .seed = 2}, kViews);
  a.OnNewPoint(7);
  b.OnNewPoint(3);
  EXPECT_NE(All(a), All(b));
  b.OnNewPoint(7);
  EXPECT_EQ(a.views(0), b.views(0));
  EXPECT_EQ(a.views(1), b.views(1));
  other.OnNewPoint(7);
  EXPECT_NE(All(a), All(other));
}

TEST(ViewBatches, OfNoViewsThereIsOneOfNone) {
  for (const BatchChoice choice : kChoices) {
    const ViewBatches batches({.count = 3, .choice = choice}, 0);
    ASSERT_EQ(batches.num_batches(), 1);
    EXPECT_TRUE(batches.views(0).empty());
    EXPECT_EQ(batches.scale(), 1);
  }
}

TEST(ViewBatches, RefusesWhatIsOutOfRange) {
  EXPECT_THROW(ViewBatches({.count = 0}, 3), Error);
  EXPECT_THROW(ViewBatches({.size = -1}, 3), Error);
}

}  // namespace
}  // namespace vesta::gs
