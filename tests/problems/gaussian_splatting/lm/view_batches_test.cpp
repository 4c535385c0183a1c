#include "problems/gaussian_splatting/lm/view_batches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "kernels/core/check.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

constexpr BatchChoice kChoices[] = {BatchChoice::kStrided, BatchChoice::kRandom, BatchChoice::kClustered};

// Groups of views, each about a place of its own; view v belongs to group v mod groups.
std::vector<splat::PinholeView> Groups(int groups, int each) {
  test::Random random(3);
  std::vector<splat::PinholeView> views;
  for (int v = 0; v < groups * each; ++v) {
    const double angle = 2 * 3.14159265 * (v % groups) / groups;
    splat::PinholeView view{};
    view.centre[0] = 5 * std::cos(angle) + 0.05 * random.Normal();
    view.centre[1] = 5 * std::sin(angle) + 0.05 * random.Normal();
    view.R[6] = -std::cos(angle), view.R[7] = -std::sin(angle);
    views.push_back(view);
  }
  return views;
}

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
  const auto views = Groups(4, 5);
  for (const BatchChoice choice : kChoices) {
    ViewBatches batches({.count = 3, .choice = choice, .seed = 5}, views);
    for (int turn = 0; turn < 3; ++turn) {
      batches.BeginTurn(turn);
      ASSERT_EQ(batches.num_batches(), 3);
      const std::vector<Index> all = All(batches);
      ASSERT_EQ(all.size(), views.size());
      for (std::size_t v = 0; v < all.size(); ++v) EXPECT_EQ(all[v], static_cast<Index>(v));
      for (int b = 0; b < 3; ++b) EXPECT_NEAR(static_cast<double>(batches.views(b).size()), 20.0 / 3, 1);
      EXPECT_EQ(batches.scale(), 1);
    }
  }
}

TEST(ViewBatches, StridedTakesEveryNth) {
  const ViewBatches batches({.count = 3}, Groups(1, 8));
  EXPECT_EQ(batches.views(0), (std::vector<Index>{0, 3, 6}));
  EXPECT_EQ(batches.views(1), (std::vector<Index>{1, 4, 7}));
  EXPECT_EQ(batches.views(2), (std::vector<Index>{2, 5}));
}

TEST(ViewBatches, AStepOfFewerViewsGoesRoundThemAll) {
  const auto views = Groups(4, 5);
  for (const BatchChoice choice : kChoices) {
    ViewBatches batches({.count = 2, .size = 3, .choice = choice, .seed = 1}, views);
    EXPECT_DOUBLE_EQ(batches.scale(), 20.0 / 6);
    std::set<Index> met;
    for (int turn = 0; turn < 40; ++turn) {
      batches.BeginTurn(turn);
      ASSERT_EQ(batches.num_batches(), 2);
      const std::vector<Index> all = All(batches);
      ASSERT_EQ(std::set<Index>(all.begin(), all.end()).size(), 6u) << "without replacement";
      met.insert(all.begin(), all.end());
    }
    EXPECT_EQ(met.size(), views.size());
  }
}

// The paper's 25 to 70 images in up to 4 batches, where there are not so many.
TEST(ViewBatches, CountAndSizeAreCutToTheViewsThereAre) {
  const auto views = Groups(1, 17);
  const auto batches_of = [&](int count, int size) {
    return ViewBatches({.count = count, .size = size}, views).num_batches();
  };
  EXPECT_EQ(batches_of(4, 25), 1);
  EXPECT_EQ(batches_of(4, 8), 3);
  EXPECT_EQ(batches_of(4, 0), 4);
  EXPECT_EQ(batches_of(100, 0), 17);
  EXPECT_EQ(batches_of(100, 1), 17);
}

TEST(ViewBatches, DrawsDependOnSeedAndTurnAlone) {
  const auto views = Groups(4, 5);
  for (const BatchChoice choice : {BatchChoice::kRandom, BatchChoice::kClustered}) {
    ViewBatches a({.count = 2, .size = 4, .choice = choice, .seed = 1}, views), b = a;
    ViewBatches other({.count = 2, .size = 4, .choice = choice, .seed = 2}, views);
    a.BeginTurn(7);
    b.BeginTurn(3);
    EXPECT_NE(All(a), All(b));
    b.BeginTurn(7);
    EXPECT_EQ(a.views(0), b.views(0));
    EXPECT_EQ(a.views(1), b.views(1));
    other.BeginTurn(7);
    EXPECT_NE(All(a), All(other));
  }
}

TEST(ViewBatches, ClustersAreTheGroups) {
  const std::vector<Index> clusters = ClusterViews(Groups(4, 5), 4, 0);
  for (std::size_t v = 0; v < clusters.size(); ++v) EXPECT_EQ(clusters[v], static_cast<Index>(v % 4));
  // Views at one place are one cluster, whatever is asked for.
  EXPECT_EQ(ClusterViews(std::vector<splat::PinholeView>(5), 3, 0), std::vector<Index>(5, 0));
}

// Four groups of five: each batch of four gets one view of each group. Random batches do not.
TEST(ViewBatches, ClusteredBatchesSeeEveryGroup) {
  const auto views = Groups(4, 5);
  const auto groups_seen = [&](BatchChoice choice) {
    ViewBatches batches({.count = 5, .choice = choice, .seed = 9}, views);
    std::size_t seen = 0;
    for (int turn = 0; turn < 4; ++turn) {
      batches.BeginTurn(turn);
      for (int b = 0; b < 5; ++b) {
        std::set<Index> groups;
        for (const Index v : batches.views(b)) groups.insert(v % 4);
        seen += groups.size();
      }
    }
    return seen;
  };
  EXPECT_EQ(groups_seen(BatchChoice::kClustered), 80u);
  EXPECT_LT(groups_seen(BatchChoice::kRandom), 70u);
}

TEST(ViewBatches, OfNoViewsThereIsOneOfNone) {
  for (const BatchChoice choice : kChoices) {
    const ViewBatches batches({.count = 3, .choice = choice}, {});
    ASSERT_EQ(batches.num_batches(), 1);
    EXPECT_TRUE(batches.views(0).empty());
    EXPECT_EQ(batches.scale(), 1);
  }
}

TEST(ViewBatches, RefusesWhatIsOutOfRange) {
  EXPECT_THROW(ViewBatches({.count = 0}, Groups(1, 3)), Error);
  EXPECT_THROW(ViewBatches({.size = -1}, Groups(1, 3)), Error);
}

}  // namespace
}  // namespace vesta::gs
