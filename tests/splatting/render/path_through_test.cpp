// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "splatting/render/camera_paths.h"
#include "splatting/render/look.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs {
namespace {

const Camera kCamera{40, 30, {50, 50, 20, 15}};

View At(const Point3& center) { return LookingAt(kCamera, center, {0, 0, 0}, {0, -1, 0}); }

// So many cameras on a circle of radius 3, at such angles, which look at its middle.
std::vector<View> Arc(int count, double angle, double height) {
  std::vector<View> views;
  views.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) views.push_back(At({3 * std::cos(angle * i), height, 3 * std::sin(angle * i)}));
  return views;
}

// NaN where one is.
double Difference(const View& a, const View& b) {
  double sum = 0;
  for (std::size_t k = 0; k < 9; ++k) sum += std::abs(a.rotation[k] - b.rotation[k]);
  for (std::size_t k = 0; k < 3; ++k) sum += std::abs(a.translation[k] - b.translation[k]);
  return sum;
}

TEST(PathThrough, StepsAreOfLengthsAndAngles) {
  View view, moved;
  moved.translation = {0.6, 0, 0};
  EXPECT_NEAR(StepBetween(view, moved, 2), 0.3, 1e-12);
  const double angle = 0.4;
  moved.rotation = {std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1};
  EXPECT_NEAR(StepBetween(view, moved, 2), 0.5, 1e-12);
}

// Keys equally far apart are met where the frames divide the way.
TEST(PathThrough, MeetsTheKeys) {
  const std::vector<View> keys = Arc(5, 0.7, 0.5);
  const std::vector<View> path = PathThrough(keys, 1, kCamera, 41);
  ASSERT_EQ(path.size(), 41u);
  for (std::size_t i = 0; i < keys.size(); ++i) EXPECT_LT(Difference(path[10 * i], keys[i]), 1e-9) << i;
}

// Between keys of a circle it is near the circle, and looks at its middle: what a way of straight pieces is not.
TEST(PathThrough, IsRoundBetweenKeysOfACircle) {
  const std::vector<View> keys = Arc(9, 0.4, 0);
  const std::vector<View> path = PathThrough(keys, 1, kCamera, 81);
  for (std::size_t k = 10; k < 71; ++k) {  // the first and last piece have no neighbour on one side
    const auto center = CameraCenter(path[k]);
    EXPECT_NEAR(std::hypot(center[0], center[2]), 3, 0.003) << "the chords' middles are at " << 3 * std::cos(0.2);
    EXPECT_NEAR(InCamera(path[k], {0, 0, 0})[0], 0, 0.005);
  }
}

// Keys at unequal distances: no frame jumps.
TEST(PathThrough, GoesAtEqualSpeed) {
  const std::vector<View> keys = {At({3, 0, 0}), At({3, 0, 0.1}), At({3, 0, 2}), At({2.9, 0, 2.1}), At({0, 0, 3})};
  const std::vector<View> path = PathThrough(keys, 1, kCamera, 200);
  double longest = 0, shortest = 1e9;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double step = StepBetween(path[i - 1], path[i], 1);
    longest = std::max(longest, step), shortest = std::min(shortest, step);
  }
  EXPECT_LT(longest / shortest, 3);
}

// Half of the rotations have a quaternion of the other sign.
TEST(PathThrough, TurnsTheShortWay) {
  const std::vector<View> keys = Arc(13, 0.5, 0);
  const std::vector<View> path = PathThrough(keys, 1, kCamera, 121);
  for (std::size_t i = 1; i < path.size(); ++i) EXPECT_LT(StepBetween(path[i - 1], path[i], 1), 0.3);
}

TEST(PathThrough, OneKeyOrTheSameTwiceStays) {
  const View key = At({1, 2, 3});
  for (const std::vector<View>& keys : {std::vector<View>{key}, std::vector<View>{key, key, key}}) {
    for (const int frames : {1, 2, 7}) {
      const std::vector<View> path = PathThrough(keys, 1, kCamera, frames);
      ASSERT_EQ(path.size(), static_cast<std::size_t>(frames));
      for (const View& view : path) EXPECT_LT(Difference(view, key), 1e-9);
    }
  }
}

}  // namespace
}  // namespace vesta::gs
