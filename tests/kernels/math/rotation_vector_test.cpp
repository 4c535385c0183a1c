// SPDX-License-Identifier: Apache-2.0
#include "kernels/math/rotation_vector.h"

#include <gtest/gtest.h>

namespace vesta {
namespace {

TEST(RotationVector, CoefficientsMeetWhereSeriesAndQuotientsDo) {
  double below[3], above[3];
  AngleCoefficients(0.25 * (1 - 1e-15), below);
  AngleCoefficients(0.25 * (1 + 1e-15), above);
  const double expected[3] = {0.958851077208406, 0.48966975243850913, 0.16459569116637598};
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(below[c], expected[c], 1e-15);
    EXPECT_NEAR(above[c], expected[c], 2e-15);
  }
}

TEST(RotationVector, CrossProducts) {
  const double a[3] = {1, 2, 3}, b[3] = {-2, 0.5, 4};
  double out[3];
  CrossProduct(a, b, out);
  EXPECT_EQ(out[0], 2 * 4 - 3 * 0.5);
  EXPECT_EQ(out[1], 3 * -2 - 1 * 4);
  EXPECT_EQ(out[2], 1 * 0.5 - 2 * -2);
}

}  // namespace
}  // namespace vesta
