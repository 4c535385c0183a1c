// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {
namespace {

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
