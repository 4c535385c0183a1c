// SPDX-License-Identifier: Apache-2.0
#include "splatting/render/look.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

const Camera kCamera{40, 30, {50, 50, 20, 15}};

TEST(Look, TargetIsInTheMiddleAndUpIsUp) {
  const Point3 center{1, 2, 3}, target{4, -2, 5}, up{0.1, -1, 0.2};
  const View view = LookingAt(kCamera, center, target, up);
  const Point3 at = InCamera(view, target), above = InCamera(view, {4.1, -3, 5.2});
  EXPECT_NEAR(at[0], 0, 1e-12);
  EXPECT_NEAR(at[1], 0, 1e-12);
  EXPECT_NEAR(at[2], std::hypot(3, 4, 2), 1e-12);
  EXPECT_NEAR(above[0], 0, 1e-12);
  EXPECT_LT(above[1], 0) << "the y axis points down";
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(CameraCenter(view)[k], center[k], 1e-12);
}

TEST(Look, AlongUpIsARotationToo) {
  const View view = LookingAt(kCamera, {0, 0, 0}, {0, -2, 0}, {0, -1, 0});
  const auto& r = view.rotation;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double dot = r[3 * i] * r[3 * j] + r[3 * i + 1] * r[3 * j + 1] + r[3 * i + 2] * r[3 * j + 2];
      EXPECT_NEAR(dot, i == j ? 1 : 0, 1e-12);
    }
  }
  EXPECT_NEAR(InCamera(view, {0, -2, 0})[2], 2, 1e-12);
}

TEST(Look, ARingLooksAtItsMiddle) {
  const Scene scene = test::RingOfCameras(9, 40, 30, false);
  for (const double coordinate : PointLookedAt(scene)) EXPECT_NEAR(coordinate, 0, 0.01);
  EXPECT_LT(UpOf(scene.views)[1], -0.99);
}

TEST(Look, ParallelAxesLookAsFarAsTheMedianDepth) {
  Scene scene;
  for (int i = 0; i < 4; ++i) {
    const double x = i;
    scene.views.push_back(LookingAt(kCamera, {x, 0, 0}, {x, 0, 1}, {0, -1, 0}));
  }
  scene.extent = 3;
  const Point3 at = PointLookedAt(scene);
  EXPECT_NEAR(at[0], 1.5, 1e-9);
  EXPECT_NEAR(at[2], 6, 1e-9);
  EXPECT_NEAR(MeanDirection(scene.views)[2], 1, 1e-12);
}

// Cameras on a quarter circle, looking down at its centre. Their own up vectors lean, but the plane of their image rows
// is level.
TEST(Look, UpOfLevelCamerasIsVertical) {
  std::vector<View> views;
  for (int i = 0; i < 10; ++i) {
    const double angle = 0.15 * i;
    views.push_back(LookingAt(kCamera, {3 * std::cos(angle), 3 * std::sin(angle), 2}, {0, 0, 0}, {0, 0, 1}));
  }
  EXPECT_GT(UpOf(views)[2], 0.999);
  // For identical cameras, only their up vector remains.
  const std::vector<View> one(3, views[0]);
  EXPECT_NEAR(UpOf(one)[2], 3 / std::sqrt(13.0), 1e-9);
}

// Cameras that look down with all rotations have no common up direction in the image.
TEST(Look, UpOfCamerasThatLookDownIsBehindThem) {
  std::vector<View> views;
  for (int i = 0; i < 8; ++i) {
    const double turn = 0.25 * M_PI * i;
    views.push_back(LookingAt(kCamera, {0.1 * i, 0, 5}, {0.1 * i, 0, 0}, {std::cos(turn), std::sin(turn), 0}));
  }
  EXPECT_NEAR(UpOf(views)[2], 1, 1e-12);
}

TEST(Look, NoViewsAreAnError) {
  EXPECT_THAT([] { PointLookedAt(Scene()); }, ThrowsError(kBadArgument));
}

}  // namespace
}  // namespace vesta::gs
