// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "problems/gaussian_splatting/model/initialize.h"
#include "tests/support/any_threads.h"

namespace vesta::gs {
namespace {

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
  vesta::test::ExpectSameForAnyThreads([&] { return MeanSquaredNeighborDistance(points); });
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

}  // namespace
}  // namespace vesta::gs
