// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/scene/scene.h"

#include <gtest/gtest.h>

#include "kernels/core/error.h"

namespace vesta::gs {
namespace {

TEST(Scene, EveryEighthByNameIsForTesting) {
  std::vector<View> views(18);
  for (std::size_t i = 0; i < views.size(); ++i) views[i].name = std::string(1, static_cast<char>('r' - i));
  SortAndSplit(&views);
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(views[i].name[0], static_cast<char>('a' + i));
    EXPECT_EQ(views[i].is_test(), i == 0 || i == 8 || i == 16);
  }
}

TEST(Scene, HoldsOutEveryEighthOfTheTrainingViews) {
  const auto held_out = [](std::size_t count) {
    std::vector<View> views(count);
    SortAndSplit(&views);
    HoldOut(&views);
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(views[i].is_test(), i % 8 == 0) << "test views keep their role";
      EXPECT_EQ(views[i].is_trained(), views[i].role == ViewRole::kTraining);
      if (views[i].role == ViewRole::kHeldOut) found.push_back(i);
    }
    return found;
  };
  // The training views are 1, 2, 3, 4, 5, 6, 7, 9, 10, ...
  EXPECT_EQ(held_out(20), (std::vector<std::size_t>{4, 13}));
  EXPECT_EQ(held_out(3), (std::vector<std::size_t>{2}));
  EXPECT_THROW(held_out(2), Error) << "one view must remain for training";
}

TEST(Scene, CenterIsWhereTheCameraMapsToZero) {
  View view;
  view.rotation = {0, -1, 0, 1, 0, 0, 0, 0, 1};
  view.translation = {5, 6, 7};
  const auto c = CameraCenter(view);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& r = view.rotation;
    EXPECT_EQ(r[3 * i] * c[0] + r[3 * i + 1] * c[1] + r[3 * i + 2] * c[2] + view.translation[i], 0);
  }
}

TEST(Scene, ExtentIsOfTheMedianDepth) {
  std::vector<View> views(3);
  for (View& view : views) view.camera = {100, 50, {50, 50, 50, 25}};
  views[0].translation = {-2, 0, 0};
  views[1].translation = {0, 0, 6};
  views[2].translation = {0, 0, 1000};
  views[2].role = ViewRole::kTest;
  // Depths: first point 10 and 16; second 20 and 26; third behind the first camera and 2 in the second; the last
  // outside both images.
  const PointCloud points{{{0, 0, 10}, {3, 0, 20}, {0, 0, -4}, {40, 0, 1}}, {}};
  EXPECT_DOUBLE_EQ(SceneExtent(views, points), 0.5 * 16);
  // The length of the row of cameras does not matter.
  views[0].translation = {-4, 0, 0};
  EXPECT_DOUBLE_EQ(SceneExtent(views, points), 0.5 * 16);
}

TEST(Scene, ExtentWithoutPointsIsTheRadiusOfTheTrainingCameras) {
  std::vector<View> views(4);
  views[0].translation = {-2, 0, 0};  // centres are the negatives of these
  views[1].translation = {2, 0, 0};
  views[2].translation = {0, 0, 0};
  views[3].translation = {100, 100, 100};
  views[3].role = ViewRole::kTest;
  EXPECT_DOUBLE_EQ(SceneExtent(views, {}), 2.2);
  views.resize(1);
  EXPECT_EQ(SceneExtent(views, {}), 1.0) << "one camera has no extent";
}

TEST(Scene, ResizedCameraSeesTheSame) {
  const Camera camera = ResizeCamera({100, 51, {80, 90, 49, 26}}, 50, 25);
  EXPECT_EQ(camera.width, 50);
  EXPECT_EQ(camera.height, 25);
  EXPECT_DOUBLE_EQ(camera.lens.fx, 40);
  EXPECT_DOUBLE_EQ(camera.lens.cx, 24.5);
  EXPECT_DOUBLE_EQ(camera.lens.fy, 90 * 25.0 / 51);
  EXPECT_DOUBLE_EQ(camera.lens.cy, 26 * 25.0 / 51);
}

TEST(Median, IsTheMiddleOneOrTheUpperOfTwo) {
  EXPECT_EQ(Median<double>({7}), 7);
  EXPECT_EQ(Median<double>({3, -1, 2}), 2);
  EXPECT_EQ(Median<float>({4, 1, 3, 2}), 3);
}

}  // namespace
}  // namespace vesta::gs
