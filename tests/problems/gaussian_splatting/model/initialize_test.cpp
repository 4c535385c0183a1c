// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/initialize.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/formulas/layout.h"

namespace vesta::gs {
namespace {

// The corners of a unit square: to each, two neighbours at distance 1 and one at the root of 2.
PointCloud Square() {
  PointCloud points;
  points.positions = {{0, 0, 5}, {1, 0, 5}, {0, 1, 5}, {1, 1, 5}};
  points.colors = {{0, 0, 0}, {1, 1, 1}, {0.25f, 0.5f, 0.75f}, {0.1f, 0.2f, 0.3f}};
  return points;
}

TEST(Initialize, PutsAGaussianAtEachPoint) {
  const PointCloud points = Square();
  const SplatModel model = InitializeFromPoints(points, 5, 2, 100);
  ASSERT_EQ(model.count, 4);
  ASSERT_EQ(model.sh_degree, 2);
  ASSERT_EQ(model.data.size(), 4u * (11 + 27));
  for (Index i = 0; i < 4; ++i) {
    const auto p = static_cast<std::size_t>(i);
    for (int k = 0; k < 3; ++k) {
      const auto c = static_cast<std::size_t>(k);
      EXPECT_EQ(model.attribute(splat::kMean + k)[i], points.positions[p][c]);
      EXPECT_NEAR(model.attribute(splat::kLogScale + k)[i], 0.5 * std::log(4.0 / 3.0), 1e-6);
      EXPECT_NEAR(0.5 + 0.28209479 * model.attribute(splat::kSh + k)[i], points.colors[p][c], 1e-6);
    }
    EXPECT_EQ(model.attribute(splat::kQuaternion)[i], 1);
    for (int k = 1; k < 4; ++k) EXPECT_EQ(model.attribute(splat::kQuaternion + k)[i], 0);
    EXPECT_NEAR(1 / (1 + std::exp(-model.attribute(splat::kOpacity)[i])), 0.1, 1e-7);
    for (int a = splat::kSh + 3; a < model.num_attributes(); ++a) EXPECT_EQ(model.attribute(a)[i], 0);
  }
}

TEST(Initialize, StridesThroughMorePointsThanAreAllowed) {
  PointCloud points;
  for (int i = 0; i < 10; ++i) {
    points.positions.push_back({static_cast<float>(i), 0, 0});
    points.colors.push_back({0, 0, 0});
  }
  const SplatModel model = InitializeFromPoints(points, 5, 0, 4);
  ASSERT_EQ(model.count, 4);
  const float expected[] = {0, 2, 5, 7};
  for (Index i = 0; i < 4; ++i) EXPECT_EQ(model.attribute(0)[i], expected[i]);
  // Sizes from the neighbours that were kept: to 0 they lie at 2, 5 and 7.
  EXPECT_NEAR(model.attribute(splat::kLogScale)[0], 0.5 * std::log((4 + 25 + 49) / 3.0), 1e-5);
}

TEST(Initialize, CoincidingPointsAndASinglePointHaveASize) {
  PointCloud points;
  points.positions.assign(5, {1, 2, 3});
  points.colors.assign(5, {0.5f, 0.5f, 0.5f});
  for (const Index count : {5, 1}) {
    const SplatModel model = InitializeFromPoints(points, 5, 1, count);
    ASSERT_EQ(model.count, count);
    for (const float value : model.data) EXPECT_TRUE(std::isfinite(value));
  }
}

// Twice as large a scene has twice as large Gaussians, however small both are.
TEST(Initialize, SizesFollowTheScale) {
  PointCloud points = Square();
  points.positions.push_back(points.positions[0]);
  points.colors.push_back(points.colors[0]);
  const SplatModel model = InitializeFromPoints(points, 5, 1, 100);
  for (const int exponent : {-30, -13, 1, 26}) {
    PointCloud scaled = points;
    for (auto& position : scaled.positions) {
      for (float& value : position) value = std::ldexp(value, exponent);
    }
    const SplatModel of_scaled = InitializeFromPoints(scaled, std::ldexp(5, exponent), 1, 100);
    for (Index i = 0; i < model.count; ++i) {
      EXPECT_NEAR(of_scaled.attribute(splat::kLogScale)[i] - model.attribute(splat::kLogScale)[i],
                  exponent * std::log(2.0), 1e-5);
    }
  }
  // Points that are one have a part of the extent.
  points.positions.assign(5, {1, 2, 3});
  EXPECT_NEAR(InitializeFromPoints(points, 5e-8, 1, 5).attribute(splat::kLogScale)[0], std::log(5e-12), 1e-5);
}

TEST(DefaultShDegree, GrowsWithTheTrainingViews) {
  EXPECT_EQ(DefaultShDegree(1), 2);
  EXPECT_EQ(DefaultShDegree(23), 2);
  EXPECT_EQ(DefaultShDegree(24), 3);
}

TEST(Initialize, RefusesNoPoints) { EXPECT_THROW(InitializeFromPoints({}, 5, 1, 10), Error); }

}  // namespace
}  // namespace vesta::gs
