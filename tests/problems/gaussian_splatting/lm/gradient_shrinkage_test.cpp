// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/lm/gradient_shrinkage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace vesta::gs {
namespace {

TEST(ViewAgreement, LeavesWhatIsUnanimousAndDropsWhatCancels) {
  const auto shrunk = [](std::vector<double> gradients, double strength) {
    double sum = 0, squares = 0;
    for (double& one : gradients) {
      AddViewGradient<double>{&one, &sum, &squares}(0);
      EXPECT_EQ(one, 0);
    }
    ShrunkGradient<double>{strength, static_cast<double>(gradients.size()), &sum, &squares}(0);
    return -squares;
  };
  EXPECT_DOUBLE_EQ(shrunk({0.1, 0.1, 0.1}, 1e6), 0.1 * 3);
  EXPECT_EQ(shrunk({1, -1}, 0.01), 0);
  EXPECT_EQ(shrunk({0, 0}, 1), 0);
  // Two views with g = 2 and a sum of squares of 4: v = 2 (4 - 4 / 2) = 4 = g^2.
  EXPECT_EQ(shrunk({0.3}, 1e6), 0.3) << "a single view is not shrunk";
  EXPECT_DOUBLE_EQ(shrunk({2, 0}, 0.25), 1.5);
  EXPECT_EQ(shrunk({2, 0}, 1), 0);
  EXPECT_DOUBLE_EQ(shrunk({-2, 0}, 0.25), -1.5);
  EXPECT_EQ(shrunk({1e200, 1}, 1), 1e200);  // squares overflow
  EXPECT_TRUE(std::isnan(shrunk({std::numeric_limits<double>::quiet_NaN(), 1}, 1)));
}

}  // namespace
}  // namespace vesta::gs
