// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "tests/problems/gaussian_splatting/host_vectors.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

// The eight corners of a cube come in the order of their numbers, x being the lowest bit.
TEST(SpatialOrder, IsMortons) {
  std::vector<std::array<float, 3>> corners;
  for (const int c : {5, 2, 7, 0, 1, 6, 3, 4}) {
    corners.push_back({static_cast<float>(c & 1), static_cast<float>(c >> 1 & 1), static_cast<float>(c >> 2)});
  }
  EXPECT_EQ(SpatialOrder(test::ModelAt(corners)), (std::vector<Index>{3, 4, 1, 6, 7, 0, 5, 2}));
}

// In memory's neighbourhoods of 16 there is less space than a random order has there.
TEST(SpatialOrder, NeighboursInMemoryAreNeighboursInSpace) {
  constexpr Index kCount = 4096;
  vesta::test::Random random(1);
  std::vector<std::array<float, 3>> means(kCount);
  for (auto& mean : means)
    mean = {static_cast<float>(random.Normal()), static_cast<float>(random.Normal()),
            static_cast<float>(random.Normal())};
  const SplatModel model = test::ModelAt(means);
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
      test::ModelAt({{0, std::nanf(""), 0}, {1e30f, 0, 0}, {-1e30f, 0, 0}, {-infinity, 0, 0}, {0, 0, 0}});
  std::vector<Index> order = SpatialOrder(model);
  std::sort(order.begin(), order.end());
  EXPECT_EQ(order, (std::vector<Index>{0, 1, 2, 3, 4}));
  EXPECT_TRUE(SpatialOrder(test::ModelAt({})).empty());
  EXPECT_EQ(SpatialOrder(test::ModelAt({{2, 2, 2}, {2, 2, 2}})), (std::vector<Index>{0, 1}));
}

}  // namespace
}  // namespace vesta::gs
