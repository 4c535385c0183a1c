// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "splatting/render/camera_paths.h"
#include "splatting/render/look.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

const Camera kCamera{40, 30, {50, 50, 20, 15}};

// Cameras on a circle of radius 3, one above the point that they look at, off the origin.
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

// One stray camera changes nothing much.
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

}  // namespace
}  // namespace vesta::gs
