// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/scene/distortion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vesta::gs {
namespace {

// The formulas of OpenCV's documentation.
std::array<double, 2> Reference(const Distortion& lens, double x, double y) {
  const double r = std::hypot(x, y);
  const auto& k = lens.radial;
  if (lens.is_fisheye) {
    const double theta = std::atan(r);
    double bent = theta;
    for (int i = 0; i < 4; ++i) bent += k[static_cast<std::size_t>(i)] * std::pow(theta, 2 * i + 3);
    return r > 0 ? std::array{bent / r * x, bent / r * y} : std::array{x, y};
  }
  double above = 1, below = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const double power = std::pow(r, 2 * static_cast<double>(i) + 2);
    above += k[i] * power;
    below += k[3 + i] * power;
  }
  const double p1 = lens.tangential[0], p2 = lens.tangential[1];
  return {x * above / below + 2 * p1 * x * y + p2 * (r * r + 2 * x * x),
          y * above / below + p1 * (r * r + 2 * y * y) + 2 * p2 * x * y};
}

const Distortion kLenses[] = {
    {},
    {.radial = {-0.2}},
    {.radial = {0.1, -0.05}},
    {.radial = {-0.3, 0.1}, .tangential = {0.003, -0.002}},
    {.radial = {0.3, -0.1, 0.02, 0.4, -0.05, 0.01}, .tangential = {-0.001, 0.004}},
    {.is_fisheye = true},
    {.is_fisheye = true, .radial = {0.05}},
    {.is_fisheye = true, .radial = {0.1, -0.03, 0.02, -0.01}},
};

TEST(Distortion, FollowsTheFormulasOfOpenCv) {
  for (const Distortion& lens : kLenses) {
    for (double x = -1.2; x <= 1.2; x += 0.3) {
      for (double y = -0.9; y <= 0.9; y += 0.3) {
        const auto bent = Distort(lens, x, y), expected = Reference(lens, x, y);
        EXPECT_NEAR(bent[0], expected[0], 1e-14);
        EXPECT_NEAR(bent[1], expected[1], 1e-14);
      }
    }
  }
}

TEST(Distortion, OfNoneLeavesAllInPlace) {
  EXPECT_TRUE(kLenses[0].is_none());
  EXPECT_EQ(Distort({}, 0.3, -0.7), (std::array{0.3, -0.7}));
  EXPECT_FALSE(kLenses[5].is_none()) << "a fisheye without coefficients is not a pinhole";
}

TEST(Distortion, JacobianIsThatOfDifferences) {
  constexpr double kStep = 1e-6;
  for (const Distortion& lens : kLenses) {
    for (const auto& [x, y] : {std::array{0.0, 0.0}, {0.4, -0.2}, {-0.8, 0.7}}) {
      const auto jacobian = DistortionJacobian(lens, x, y);
      const auto right = Distort(lens, x + kStep, y), left = Distort(lens, x - kStep, y);
      const auto below = Distort(lens, x, y + kStep), above = Distort(lens, x, y - kStep);
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_NEAR(jacobian[2 * i], (right[i] - left[i]) / (2 * kStep), 1e-8);
        EXPECT_NEAR(jacobian[2 * i + 1], (below[i] - above[i]) / (2 * kStep), 1e-8);
      }
    }
  }
}

// Near the axis the angle equals its tangent: both formulas for the ratio must agree.
TEST(Distortion, OfAFisheyeIsSmoothAtTheAxis) {
  for (const double r : {1e-9, 0.99e-5, 1.01e-5, 1e-4}) {
    const auto bent = Distort(kLenses[7], r, 0.0), expected = Reference(kLenses[7], r, 0.0);
    EXPECT_NEAR(bent[0] / expected[0], 1, 1e-15) << r;
    EXPECT_NEAR(DistortionJacobian(kLenses[7], r, 0)[0], 1, 1e-7) << r;
  }
}

TEST(Distortion, KnowsWhatIsNotFinite) {
  EXPECT_TRUE(kLenses[4].is_finite());
  EXPECT_FALSE((Distortion{.radial = {0, 0, NAN}}).is_finite());
  EXPECT_FALSE((Distortion{.tangential = {0, INFINITY}}).is_finite());
}

}  // namespace
}  // namespace vesta::gs
