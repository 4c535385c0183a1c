// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/initialize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

// Corners of a unit square: each has two neighbours at distance 1 and one at the square root of 2.
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
  // Only kept neighbours determine the size: for point 0 at 2, 5 and 7.
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

// A scene scaled by two has Gaussians scaled by two, however small.
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
  // If all points coincide: a fraction of the extent.
  points.positions.assign(5, {1, 2, 3});
  EXPECT_NEAR(InitializeFromPoints(points, 5e-8, 1, 5).attribute(splat::kLogScale)[0], std::log(5e-12), 1e-5);
}

TEST(DefaultShDegree, GrowsWithTheTrainingViews) {
  EXPECT_EQ(DefaultShDegree(1), 2);
  EXPECT_EQ(DefaultShDegree(23), 2);
  EXPECT_EQ(DefaultShDegree(24), 3);
}

TEST(Initialize, RefusesNoPoints) { EXPECT_THROW(InitializeFromPoints({}, 5, 1, 10), Error); }

using Points = std::vector<std::array<float, 3>>;

Points RandomPositions(int count) {
  std::mt19937 random(3);
  Points points(static_cast<std::size_t>(count));
  for (auto& p : points) {
    for (float& v : p) v = static_cast<float>(random() % 4096) / 64;
  }
  return points;
}

std::vector<float> BruteForce(const Points& points) {
  std::vector<float> means;
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::vector<double> distances;
    for (std::size_t j = 0; j < points.size(); ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k)
        sum += (double{points[i][k]} - points[j][k]) * (double{points[i][k]} - points[j][k]);
      if (i != j) distances.push_back(sum);
    }
    std::sort(distances.begin(), distances.end());
    means.push_back(static_cast<float>((distances[0] + distances[1] + distances[2]) / 3));
  }
  return means;
}

TEST(Knn, AgreesWithBruteForce) {
  const Points points = RandomPositions(700);
  EXPECT_EQ(MeanSquaredNeighborDistance(points), BruteForce(points));
}

TEST(Knn, SameBitsForAnyNumberOfThreads) {
  const Points points = RandomPositions(5000);
  SetNumThreads(1);
  const std::vector<float> one = MeanSquaredNeighborDistance(points);
  SetNumThreads(3);
  EXPECT_EQ(MeanSquaredNeighborDistance(points), one);
  SetNumThreads(0);
}

TEST(Knn, FewPoints) {
  EXPECT_TRUE(MeanSquaredNeighborDistance({}).empty());
  EXPECT_EQ(MeanSquaredNeighborDistance({{1, 2, 3}}), std::vector<float>{0});
  EXPECT_EQ(MeanSquaredNeighborDistance({{0, 0, 0}, {0, 3, 4}}), (std::vector<float>{25, 25}));
  EXPECT_EQ(MeanSquaredNeighborDistance({{0, 0, 0}, {1, 0, 0}, {3, 0, 0}}), (std::vector<float>{5, 2.5, 6.5}));
}

TEST(Knn, CoincidingPointsAreNeighboursAtZero) {
  Points points(3000, {1, 2, 3});
  points.push_back({1, 2, 5});
  const std::vector<float> means = MeanSquaredNeighborDistance(points);
  EXPECT_TRUE(std::all_of(means.begin(), means.end() - 1, [](float v) { return v == 0; }));
  EXPECT_EQ(means.back(), 4);
}

SplatModel AtMeans(const std::vector<std::array<float, 3>>& means) {
  SplatModel model;
  model.Resize(0, static_cast<Index>(means.size()));
  for (std::size_t i = 0; i < means.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) model.attribute(splat::kMean + static_cast<int>(k))[i] = means[i][k];
  }
  return model;
}

// The corners of a cube are ordered by their numbers, with x as the lowest bit.
TEST(SpatialOrder, IsMortons) {
  std::vector<std::array<float, 3>> corners;
  for (const int c : {5, 2, 7, 0, 1, 6, 3, 4}) {
    corners.push_back({static_cast<float>(c & 1), static_cast<float>(c >> 1 & 1), static_cast<float>(c >> 2)});
  }
  EXPECT_EQ(SpatialOrder(AtMeans(corners)), (std::vector<Index>{3, 4, 1, 6, 7, 0, 5, 2}));
}

// 16 consecutive Gaussians occupy a smaller volume than in a random order.
TEST(SpatialOrder, NeighboursInMemoryAreNeighboursInSpace) {
  constexpr Index kCount = 4096;
  test::Random random(1);
  std::vector<std::array<float, 3>> means(kCount);
  for (auto& mean : means)
    mean = {static_cast<float>(random.Normal()), static_cast<float>(random.Normal()),
            static_cast<float>(random.Normal())};
  const SplatModel model = AtMeans(means);
  const std::vector<Index> order = SpatialOrder(model);
  std::vector<Index> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  std::vector<Index> all(kCount);
  std::iota(all.begin(), all.end(), Index{0});
  EXPECT_EQ(sorted, all);
  const auto distance = [&](const SplatModel& m) {
    double sum = 0;
    for (Index i = 0; i + 1 < kCount; ++i) {
      double squares = 0;
      for (int k = 0; k < 3; ++k) squares += std::pow(m.attribute(k)[i + 1] - m.attribute(k)[i], 2);
      sum += std::sqrt(squares);
    }
    return sum;
  };
  EXPECT_LT(distance(InOrder(model, order)), distance(model) / 5);
}

TEST(SpatialOrder, WhateverTheMeansAreEachComesOnce) {
  const float infinity = std::numeric_limits<float>::infinity();
  const SplatModel model =
      AtMeans({{0, std::nanf(""), 0}, {1e30f, 0, 0}, {-1e30f, 0, 0}, {-infinity, 0, 0}, {0, 0, 0}});
  std::vector<Index> order = SpatialOrder(model);
  std::sort(order.begin(), order.end());
  EXPECT_EQ(order, (std::vector<Index>{0, 1, 2, 3, 4}));
  EXPECT_TRUE(SpatialOrder(AtMeans({})).empty());
  EXPECT_EQ(SpatialOrder(AtMeans({{2, 2, 2}, {2, 2, 2}})), (std::vector<Index>{0, 1}));
}

}  // namespace
}  // namespace vesta::gs
