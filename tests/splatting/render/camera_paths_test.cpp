// SPDX-License-Identifier: Apache-2.0
#include "splatting/render/camera_paths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "splatting/render/look.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

const Camera kCamera{40, 30, {50, 50, 20, 15}};

// Cameras on a circle of radius 3, one unit above the point they look at, away from the origin.
Scene Circle(int views, double part_of_turn) {
  Scene scene;
  for (int i = 0; i < views; ++i) {
    const double angle = 2 * M_PI * part_of_turn * i / views;
    scene.views.push_back(
        LookingAt(kCamera, {5 + 3 * std::cos(angle), 1 + 3 * std::sin(angle), 3}, {5, 1, 2}, {0, 0, 1}));
  }
  return scene;
}

TEST(Orbit, GoesThroughTheCamerasOfACircle) {
  const Scene scene = Circle(6, 1);
  const Orbit orbit = OrbitOf(scene, kCamera, 6);
  ASSERT_EQ(orbit.views.size(), 6u);
  std::size_t found = 0;
  for (const View& view : scene.views) {
    for (const View& other : orbit.views) {
      double difference = 0;
      for (std::size_t k = 0; k < 3; ++k) difference += std::abs(CameraCenter(view)[k] - CameraCenter(other)[k]);
      for (std::size_t k = 0; k < 9; ++k) difference += std::abs(view.rotation[k] - other.rotation[k]);
      found += difference < 0.02 ? 1 : 0;
    }
  }
  EXPECT_EQ(found, 6u);
  EXPECT_NEAR(orbit.unseen_degrees, 60, 0.5);
  EXPECT_EQ(orbit.views[3].camera.width, 40);
}

TEST(Orbit, BeginsAtTheFirstCameraAndSaysWhatNobodyHasSeen) {
  const Scene scene = Circle(10, 0.25);
  const Orbit orbit = OrbitOf(scene, kCamera, 30);
  const auto first = CameraCenter(scene.views[0]), begin = CameraCenter(orbit.views[0]);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(begin[k], first[k], 0.05);
  EXPECT_NEAR(orbit.unseen_degrees, 360 - 81, 1);
}

// One distant camera has little effect.
TEST(Orbit, IsAtTheMedianDistance) {
  Scene scene = Circle(9, 1);
  scene.views.push_back(LookingAt(kCamera, {5, 60, 30}, {5, 1, 2}, {0, 0, 1}));
  for (const View& view : OrbitOf(scene, kCamera, 7).views) {
    const auto center = CameraCenter(view);
    EXPECT_NEAR(std::hypot(center[0] - 5, center[1] - 1), 3, 0.1);
    EXPECT_NEAR(center[2], 3, 0.1);
  }
}

TEST(Orbit, OfNothingIsAnError) {
  EXPECT_THAT([] { OrbitOf(Scene(), kCamera, 5); }, ThrowsError(kBadArgument));
  EXPECT_THAT([] { OrbitOf(Circle(3, 1), kCamera, 0); }, ThrowsError(kBadArgument, "0"));
}

View At(const Point3& center) { return LookingAt(kCamera, center, {0, 0, 0}, {0, -1, 0}); }

// `count` cameras on a circle of radius 3, spaced by `angle`, looking at its centre.
std::vector<View> Arc(int count, double angle, double height) {
  std::vector<View> views;
  views.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) views.push_back(At({3 * std::cos(angle * i), height, 3 * std::sin(angle * i)}));
  return views;
}

// Summed absolute difference of two poses.
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

// Equidistant keys are hit exactly if the number of frames divides evenly.
TEST(PathThrough, MeetsTheKeys) {
  const std::vector<View> keys = Arc(5, 0.7, 0.5);
  const std::vector<View> path = PathThrough(keys, 1, kCamera, 41);
  ASSERT_EQ(path.size(), 41u);
  for (std::size_t i = 0; i < keys.size(); ++i) EXPECT_LT(Difference(path[10 * i], keys[i]), 1e-9) << i;
}

// Between keys on a circle the path stays near it and looks at its centre, unlike straight segments.
TEST(PathThrough, IsRoundBetweenKeysOfACircle) {
  const std::vector<View> keys = Arc(9, 0.4, 0);
  const std::vector<View> path = PathThrough(keys, 1, kCamera, 81);
  for (std::size_t k = 10; k < 71; ++k) {  // the first and last segments lack a neighbour
    const auto center = CameraCenter(path[k]);
    EXPECT_NEAR(std::hypot(center[0], center[2]), 3, 0.003)
        << "the middles of the chords are at radius " << 3 * std::cos(0.2);
    EXPECT_NEAR(InCamera(path[k], {0, 0, 0})[0], 0, 0.005);
  }
}

// Unequally spaced keys: no frame jumps.
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

// Half of the quaternions have the opposite sign.
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

// 5 x 5 cameras in the plane z = 1 that look along z; 4 wide, 2 high.
Scene Grid() {
  Scene scene;
  for (int i = 0; i < 25; ++i) {
    const int row = i / 5, column = i % 5;
    const double x = column - 2, y = 0.5 * row - 1;
    scene.views.push_back(LookingAt(kCamera, {x, y, 1}, {x, y, 2}, {0, -1, 0}));
  }
  scene.extent = 2;
  return scene;
}

TEST(Spiral, StaysAmongTheCamerasAndLooksAtOnePoint) {
  const std::vector<View> views = SpiralOf(Grid(), kCamera, 40);
  ASSERT_EQ(views.size(), 40u);
  double widest = 0, highest = 0;
  for (const View& view : views) {
    const auto center = CameraCenter(view);
    widest = std::max(widest, std::abs(center[0])), highest = std::max(highest, std::abs(center[1]));
    EXPECT_NEAR(center[2], 1, 1e-9) << "all cameras lie in one plane";
    const auto focus = InCamera(view, {0, 0, 5});
    EXPECT_NEAR(focus[0], 0, 1e-9);
    EXPECT_NEAR(focus[1], 0, 1e-9);
    EXPECT_LT(InCamera(view, {0, -1, 5})[1], 0);
  }
  EXPECT_NEAR(widest, 2, 0.02);
  EXPECT_NEAR(highest, 1, 0.02);
}

// Cameras along a walk. The spiral does not pass the point it looks at, where the camera would turn around.
TEST(Spiral, StaysBeforeWhatItLooksAt) {
  Scene scene = Grid();
  for (std::size_t i = 0; i < 25; ++i) scene.views[i].translation[2] = -static_cast<double>(i);
  for (const View& view : SpiralOf(scene, kCamera, 40)) EXPECT_GT(view.rotation[8], 0.5) << "looks along z";
}

TEST(Spiral, GoesForwardAndBackWhereCamerasDo) {
  Scene scene = Grid();
  for (std::size_t i = 0; i < 25; ++i) scene.views[i].translation[2] += i % 2 == 0 ? 0.3 : -0.3;
  double nearest = 1, farthest = 1;
  for (const View& view : SpiralOf(scene, kCamera, 40)) {
    nearest = std::min(nearest, CameraCenter(view)[2]), farthest = std::max(farthest, CameraCenter(view)[2]);
  }
  EXPECT_NEAR(farthest - nearest, 0.6, 0.05);
}

TEST(Spiral, IsForCamerasThatFaceOneWay) {
  EXPECT_THAT([] { SpiralOf(test::RingOfCameras(8, 40, 30, false), kCamera, 10); }, ThrowsError(kBadArgument));
}

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

// A nearest-neighbour tour starts from the middle of the row to one side and must return for the rest. It is shortened;
// the first view stays first.
TEST(Tour, IsUntangled) {
  std::vector<View> row(6);
  const double at[6] = {0, 1, -1.1, 3.3, -3.4, 7.9};
  for (std::size_t i = 0; i < 6; ++i) row[i].translation[0] = at[i];
  const Tour tour = TourOf(row, 1);
  EXPECT_THAT(tour.order, testing::ElementsAre(0, 4, 2, 1, 3, 5));
}

}  // namespace

}  // namespace vesta::gs
