// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "splatting/parsimony/support.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs {
namespace {

constexpr Index kCount = 300;

// What Gaussian 7 of a ball of them becomes: so far off the middle along y, with this deviation and opacity.
SplatModel WithOneAt(double y, double deviation, double opacity) {
  SplatModel model = test::RandomModel(kCount, 0, 4);
  for (int k = 0; k < 3; ++k) {
    model.attribute(splat::kMean + k)[7] = k == 1 ? static_cast<float>(y) : 0;
    model.attribute(splat::kLogScale + k)[7] = static_cast<float>(std::log(deviation));
  }
  model.attribute(splat::kOpacity)[7] = static_cast<float>(std::log(opacity / (1 - opacity)));
  return model;
}

bool Keeps(const FloaterCount& count, Index i) { return std::ranges::find(count.kept, i) != count.kept.end(); }

TEST(Floaters, ABallOfGaussiansHasNone) {
  const FloaterCount count = FindFloaters(test::RandomModel(kCount, 0, 4), nullptr);
  EXPECT_EQ(count.kept.size(), static_cast<std::size_t>(kCount));
  EXPECT_TRUE(std::ranges::is_sorted(count.kept));
}

TEST(Floaters, FaintIsWhatIsNeverDrawn) {
  EXPECT_EQ(FindFloaters(WithOneAt(0.1, 0.1, 1.01 / 255), nullptr).faint, 0);
  const FloaterCount count = FindFloaters(WithOneAt(0.1, 0.1, 0.99 / 255), nullptr);
  EXPECT_EQ(count.faint, 1);
  EXPECT_FALSE(Keeps(count, 7));
  EXPECT_EQ(count.kept.size(), static_cast<std::size_t>(kCount - 1));
}

TEST(Floaters, HugeIsWhatReachesAroundAll) {
  EXPECT_EQ(FindFloaters(WithOneAt(0, 0.3, 0.5), nullptr).huge, 0);
  const FloaterCount count = FindFloaters(WithOneAt(0, 2, 0.5), nullptr);
  EXPECT_EQ(count.huge, 1);
  EXPECT_FALSE(Keeps(count, 7));
  // A sky is large and far away.
  EXPECT_EQ(FindFloaters(WithOneAt(50, 20, 0.5), nullptr).huge, 0);
}

TEST(Floaters, IsolatedIsFarFromAllForItsSize) {
  EXPECT_EQ(FindFloaters(WithOneAt(0.9, 0.05, 0.5), nullptr).isolated, 0);
  const FloaterCount count = FindFloaters(WithOneAt(6, 0.05, 0.5), nullptr);
  EXPECT_EQ(count.isolated, 1);
  EXPECT_FALSE(Keeps(count, 7));
  EXPECT_EQ(FindFloaters(WithOneAt(6, 2, 0.5), nullptr).isolated, 0) << "it reaches the others";
}

TEST(Floaters, UnsupportedIsWhatNoViewShows) {
  const Scene scene = test::RingOfCameras(6, 60, 40, false);
  const JudgingViews judges = TrainingViewsOf(scene, {0, 0, 0});
  EXPECT_EQ(FindFloaters(test::RandomModel(kCount, 0, 4), &judges).unsupported, 0);
  const SplatModel model = WithOneAt(4.5, 0.9, 0.5);  // above the images of all cameras
  EXPECT_EQ(FindFloaters(model, nullptr).kept.size(), static_cast<std::size_t>(kCount));
  const FloaterCount count = FindFloaters(model, &judges);
  EXPECT_EQ(count.unsupported, 1);
  EXPECT_FALSE(Keeps(count, 7));
}

TEST(Floaters, FewGaussiansOrAllAtOnePlaceAreNoError) {
  for (const Index gaussians : {Index{1}, Index{2}, Index{5}}) {
    SplatModel model = test::RandomModel(gaussians, 0, 4);
    std::fill_n(model.data.begin(), 3 * gaussians, 1.0f);  // the means
    EXPECT_EQ(FindFloaters(model, nullptr).kept.size(), static_cast<std::size_t>(gaussians));
  }
  SplatModel faint = test::RandomModel(3, 0, 4);
  std::fill_n(faint.attribute(splat::kOpacity), 3, -20.0f);
  EXPECT_TRUE(FindFloaters(faint, nullptr).kept.empty());
}

}  // namespace
}  // namespace vesta::gs
