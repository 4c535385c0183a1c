// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "tests/problems/gaussian_splatting/host_vectors.h"

namespace vesta::gs {
namespace {

using testing::ElementsAre;

TEST(Box, HoldsWhatLiesWithinInEachAxis) {
  const SplatModel model = test::ModelAt({{0, 0, 0}, {2, 0, 0}, {0, -3, 0}, {0.5f, 0.5f, 4}, {1, 1, 1}, {-1, -1, -1}});
  EXPECT_THAT(GaussiansWithin(model, {{-1, -1, -1}, {1, 1, 1}}), ElementsAre(0, 4, 5));
  EXPECT_THAT(GaussiansWithin(model, {{10, 10, 10}, {11, 11, 11}}), ElementsAre());
}

TEST(Box, IsInTheWorldOfTheFile) {
  SplatModel model = test::ModelAt({{0, 0, 0}, {2, 0, 0}});
  model.origin = {1e6, 0, 0};
  EXPECT_THAT(GaussiansWithin(model, {{1e6 + 1, -1, -1}, {1e6 + 3, 1, 1}}), ElementsAre(1));
  EXPECT_THAT(GaussiansWithin(model, {{-1, -1, -1}, {1, 1, 1}}), ElementsAre());
}

}  // namespace
}  // namespace vesta::gs
