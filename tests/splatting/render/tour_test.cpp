// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "splatting/render/camera_paths.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs {
namespace {

std::vector<View> InOrderOf(const std::vector<View>& views, const std::vector<std::size_t>& order) {
  std::vector<View> ordered;
  ordered.reserve(order.size());
  for (const std::size_t i : order) ordered.push_back(views[i]);
  return ordered;
}

TEST(Tour, AnOrderThatGoesAlongStays) {
  const std::vector<View> views = test::RingOfCameras(12, 20, 10, false).views;
  const Tour tour = TourOf(views, 1);
  EXPECT_FALSE(tour.is_reordered);
  EXPECT_EQ(tour.order[5], 5u);
  EXPECT_EQ(TourOf({views[0]}, 1).order.size(), 1u);
}

TEST(Tour, JumpsAreReordered) {
  const std::vector<View> ring = test::RingOfCameras(12, 20, 10, false).views;
  const std::vector<std::size_t> jumps = {0, 6, 1, 7, 2, 8, 3, 9, 4, 10, 5, 11};
  const Tour tour = TourOf(InOrderOf(ring, jumps), 1);
  EXPECT_TRUE(tour.is_reordered);
  EXPECT_EQ(tour.order[0], 0u);
  std::vector<std::size_t> visited, all(12);
  for (const std::size_t i : tour.order) visited.push_back(jumps[i]);
  std::iota(all.begin(), all.end(), 0u);
  std::vector<std::size_t> backwards = {0, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1};
  EXPECT_THAT(visited, testing::AnyOf(all, backwards)) << "once around";
}

// From each to the nearest leaves the middle of a row one way, and has to come back for the rest; the first stays.
TEST(Tour, IsUntangled) {
  std::vector<View> row(6);
  const double at[6] = {0, 1, -1.1, 3.3, -3.4, 7.9};
  for (std::size_t i = 0; i < 6; ++i) row[i].translation[0] = at[i];
  const Tour tour = TourOf(row, 1);
  EXPECT_THAT(tour.order, testing::ElementsAre(0, 4, 2, 1, 3, 5));
}

}  // namespace
}  // namespace vesta::gs
