// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/formulas/color.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/kernels/gaussian_splatting/reference.h"
#include "tests/support/random.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

TEST(Sigmoid, SaturatesWithoutOverflow) {
  EXPECT_EQ(Sigmoid(0.0), 0.5);
  EXPECT_EQ(Sigmoid(1e4), 1);
  EXPECT_EQ(Sigmoid(-1e4), 0);
  EXPECT_EQ(Sigmoid(-1e4f), 0);
  EXPECT_NEAR(Sigmoid(2.0), 0.88079707797788243, 1e-15);
}

// The colour and its derivative by the mean agree with Jets and an independent basis, near and far.
template <int Degree>
void CheckColor(double distance) {
  using Jet = ceres::Jet<double, 3>;
  constexpr int kCount = ShCoefficients(Degree);
  test::Random random(7 + Degree);
  for (int trial = 0; trial < 20; ++trial) {
    const PosedCamera view = test::RandomView(random, 64, 48);
    double mean[3], sh[3 * kCount], color_bar[3], norm2 = 0;
    for (int i = 0; i < 3; ++i) mean[i] = random.Normal(), norm2 += mean[i] * mean[i];
    for (int i = 0; i < 3; ++i) mean[i] = view.centre[i] + distance * mean[i] / std::sqrt(norm2);
    for (double& value : sh) value = random.Normal();
    for (double& value : color_bar) value = random.Normal();
    const auto coefficient = [&](int a) { return sh[a]; };

    Jet offset[3], basis_jet[kCount];
    for (int i = 0; i < 3; ++i) offset[i] = Jet(mean[i], i) - view.centre[i];
    const Jet length = sqrt(offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2]);
    const Jet direction[3] = {offset[0] / length, offset[1] / length, offset[2] / length};
    test::LegendreShBasis(Degree, direction, basis_jet);
    Jet expected(0.0);
    double value[3];
    for (int c = 0; c < 3; ++c) {
      Jet sum(0.5);
      for (int k = 0; k < kCount; ++k) sum += basis_jet[k] * sh[3 * k + c];
      value[c] = sum.a;
      expected += color_bar[c] * sum;
    }

    double dir[3], basis[kCount], color[3];
    const double inverse = ViewDirection(view.centre, mean, dir);
    ShBasis<Degree>(dir[0], dir[1], dir[2], basis);
    ShColor<Degree>(basis, coefficient, color);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(color[c], value[c], 1e-13);
    EXPECT_NEAR(inverse * distance, 1, 1e-12);

    const double before[3] = {1 / distance, -2 / distance, 3 / distance};
    double mean_bar[3];
    std::copy_n(before, 3, mean_bar);
    ShColorMeanAdjoint<Degree>(dir, inverse, coefficient, color_bar, mean_bar);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(mean_bar[i] - before[i], expected.v[i], 1e-9 * expected.v.norm() + 1e-14 / distance);
    }
  }
}

class Color : public testing::TestWithParam<double> {};

TEST_P(Color, ValueAndAdjointAgreeWithJets) {
  CheckColor<0>(GetParam());
  CheckColor<1>(GetParam());
  CheckColor<2>(GetParam());
  CheckColor<3>(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Distances, Color, testing::Values(0.02, 1.0, 300.0));

}  // namespace
}  // namespace vesta::splat
