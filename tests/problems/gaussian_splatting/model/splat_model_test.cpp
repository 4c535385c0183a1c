// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/splat_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "problems/gaussian_splatting/model/initialize.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

const std::vector<std::uint8_t> kDegrees = {1, 3, 0, 2, 3, 0, 1};

SplatModel Mixed() { return test::WithDegrees(test::RandomModel(7, 3, 11), kDegrees); }

TEST(Degrees, HighestComeFirstAndOthersStayInOrder) {
  const SplatModel model = test::RandomModel(7, 3, 11), mixed = test::WithDegrees(model, kDegrees);
  EXPECT_EQ(mixed.layout(), splat::LayoutOfBands({7, 5, 3, 2}));
  EXPECT_EQ(static_cast<Index>(mixed.data.size()), mixed.Size());
  const std::vector<Index> source = {1, 4, 3, 0, 6, 2, 5};
  for (Index k = 0; k < mixed.count; ++k) {
    const Index i = source[static_cast<std::size_t>(k)];
    EXPECT_EQ(mixed.DegreeOf(k), kDegrees[static_cast<std::size_t>(i)]);
    for (int a = 0; a < model.num_attributes(); ++a) {
      const bool has = a < splat::NumAttributes(mixed.DegreeOf(k));
      EXPECT_EQ(mixed.Value(a, k), has ? model.attribute(a)[i] : 0.0f) << a;
    }
  }
}

TEST(Degrees, AreLoweredFurtherAndNeverRaised) {
  const SplatModel lower = test::WithDegrees(Mixed(), {0, 2, 2, 1, 0, 0, 0});
  EXPECT_EQ(lower.layout(), splat::LayoutOfBands({7, 3, 2, 0}));
  EXPECT_EQ(lower.sh_degree, 2);
  EXPECT_EQ(lower.attribute(splat::kSh)[0], Mixed().attribute(splat::kSh)[1]);
  EXPECT_THROW(test::WithDegrees(Mixed(), {3, 3, 3, 0, 0, 0, 0}), Error);
  EXPECT_THROW(test::WithDegrees(Mixed(), {0, 0}), Error);
}

TEST(Degrees, OfFilesAreThoseOfTheHighestBandThatIsNotZero) {
  const SplatModel mixed = Mixed(), whole = AtOneDegree(mixed);
  EXPECT_TRUE(whole.is_uniform());
  EXPECT_EQ(whole.sh_degree, 3);
  const SplatModel again = AtStoredDegrees(whole);
  EXPECT_EQ(again.layout(), mixed.layout());
  EXPECT_EQ(again.data, mixed.data);
  EXPECT_EQ(AtStoredDegrees(mixed).data, mixed.data);
  // Also in another order.
  std::vector<Index> turned = {6, 5, 4, 3, 2, 1, 0};
  EXPECT_EQ(AtStoredDegrees(InOrder(whole, turned)).layout(), mixed.layout());
}

TEST(Degrees, OfFilesWhoseBandsWereNotTrainedAreAllTheSame) {
  SplatModel model = test::RandomModel(7, 3, 11);
  EXPECT_EQ(AtStoredDegrees(model).data, model.data);
  for (int a = splat::FirstOfBand(3); a < splat::kMaxAttributes; ++a) std::fill_n(model.attribute(a), 7, 0.0f);
  for (int a = splat::FirstOfBand(2); a < splat::FirstOfBand(3); ++a) std::fill_n(model.attribute(a), 3, 0.0f);
  const SplatModel again = AtStoredDegrees(model);
  EXPECT_EQ(again.layout(), model.layout());
  EXPECT_EQ(again.data, model.data);
}

TEST(Degrees, StayInTheOrderOfSpaceAndAreKeptInAnOrderOfTheirs) {
  const SplatModel mixed = Mixed();
  const std::vector<Index> order = SpatialOrder(mixed);
  const SplatModel sorted = InOrder(mixed, order);
  EXPECT_EQ(sorted.layout(), mixed.layout());
  const SplatModel some = InOrder(mixed, {0, 2, 4, 6});
  EXPECT_EQ(some.layout(), splat::LayoutOfBands({4, 3, 2, 1}));
  for (int a = 0; a < mixed.num_attributes(); ++a) {
    for (Index k = 0; k < some.count; ++k) EXPECT_EQ(some.Value(a, k), mixed.Value(a, 2 * k));
  }
  EXPECT_THROW(InOrder(mixed, {2, 0}), Error);
}

using testing::ElementsAre;

SplatModel MeansAt(const std::vector<std::array<float, 3>>& means) {
  SplatModel model;
  model.Resize(0, static_cast<Index>(means.size()));
  for (std::size_t i = 0; i < means.size(); ++i) {
    for (int k = 0; k < 3; ++k) model.attribute(splat::kMean + k)[i] = means[i][static_cast<std::size_t>(k)];
  }
  return model;
}

TEST(Box, HoldsWhatLiesWithinInEachAxis) {
  const SplatModel model = MeansAt({{0, 0, 0}, {2, 0, 0}, {0, -3, 0}, {0.5f, 0.5f, 4}, {1, 1, 1}, {-1, -1, -1}});
  EXPECT_THAT(GaussiansWithin(model, {{-1, -1, -1}, {1, 1, 1}}), ElementsAre(0, 4, 5));
  EXPECT_THAT(GaussiansWithin(model, {{10, 10, 10}, {11, 11, 11}}), ElementsAre());
}

TEST(Box, IsInTheWorldOfTheFile) {
  SplatModel model = MeansAt({{0, 0, 0}, {2, 0, 0}});
  model.origin = {1e6, 0, 0};
  EXPECT_THAT(GaussiansWithin(model, {{1e6 + 1, -1, -1}, {1e6 + 3, 1, 1}}), ElementsAre(1));
  EXPECT_THAT(GaussiansWithin(model, {{-1, -1, -1}, {1, 1, 1}}), ElementsAre());
}

}  // namespace
}  // namespace vesta::gs
