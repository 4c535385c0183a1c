// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "splatting/render/camera_paths.h"
#include "splatting/render/look.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

const Camera kCamera{40, 30, {50, 50, 20, 15}};

// A grid of 5 x 5 cameras in the plane z = 1 that look along z: 4 wide, 2 high.
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

// A walk: never past what is looked at, which would turn the camera round.
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

}  // namespace
}  // namespace vesta::gs
