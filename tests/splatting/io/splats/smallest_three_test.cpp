// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "splatting/io/splats/packed_values.h"

namespace vesta::gs {
namespace {

TEST(SmallestThree, GivesTheRotationBack) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 1000; ++trial) {
    std::array<double, 4> q;
    double norm2 = 0;
    for (double& value : q) {
      value = static_cast<double>(random() % 2001) / 1000 - 1;
      norm2 += value * value;
    }
    if (norm2 == 0) continue;
    const SmallestThree three = ToSmallestThree(q);
    for (const double value : three.rest) EXPECT_LE(std::abs(value), kLargestOfSmallest + 1e-12);
    const std::array<double, 4> again = FromSmallestThree(three);
    EXPECT_GE(again[static_cast<std::size_t>(three.largest)], 0.5);
    const double sign = std::copysign(1.0, q[static_cast<std::size_t>(three.largest)]);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(again[k], sign * q[k] / std::sqrt(norm2), 1e-12);
  }
}

TEST(SmallestThree, NumbersOfNoRotationHaveNoLargest) {
  EXPECT_EQ(FromSmallestThree({1, {0.7, 0.7, -0.7}}), (std::array<double, 4>{0.7, 0, 0.7, -0.7}));
}

}  // namespace
}  // namespace vesta::gs
