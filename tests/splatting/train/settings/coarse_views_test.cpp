// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/settings/coarse_views.h"

#include <gtest/gtest.h>

namespace vesta::gs {
namespace {

View OfSize(int width, int height) {
  View view;
  view.name = "a.png";
  view.camera = {width, height, {300, 310, 0.5 * width + 3, 0.5 * height - 2}};
  view.rotation = {0, 1, 0, 0, 0, 1, 1, 0, 0};
  view.translation = {1, 2, 3};
  view.image = Image(width, height);
  for (std::size_t i = 0; i < view.image.rgb.size(); ++i) view.image.rgb[i] = static_cast<float>(i % 7);
  return view;
}

TEST(CoarseViews, HalveImagesAndCameras) {
  const View full = OfSize(200, 130);
  const std::vector<View> coarse = CoarseViews({&full});
  ASSERT_EQ(coarse.size(), 1u);
  const View& half = coarse[0];
  EXPECT_EQ(half.camera.width, 100);
  EXPECT_EQ(half.camera.height, 65);
  EXPECT_DOUBLE_EQ(half.camera.lens.fx, 150);
  EXPECT_DOUBLE_EQ(half.camera.lens.fy, 155);
  EXPECT_DOUBLE_EQ(half.camera.lens.cx, 51.5);
  EXPECT_DOUBLE_EQ(half.camera.lens.cy, 31.5);
  EXPECT_EQ(half.rotation, full.rotation);
  EXPECT_EQ(half.translation, full.translation);
  ASSERT_EQ(half.image.width, 100);
  ASSERT_EQ(half.image.height, 65);
  const float* plane = full.image.plane(1);
  EXPECT_NEAR(half.image.plane(1)[100 + 4],
              (plane[2 * 200 + 8] + plane[2 * 200 + 9] + plane[3 * 200 + 8] + plane[3 * 200 + 9]) / 4, 1e-6);
}

TEST(CoarseViews, LeaveSmallOnesAsTheyAre) {
  const View large = OfSize(200, 128), small = OfSize(200, 127);
  const std::vector<View> coarse = CoarseViews({&large, &small});
  EXPECT_EQ(coarse[0].image.height, 64);
  EXPECT_EQ(coarse[1].image.height, 127);
  EXPECT_EQ(coarse[1].camera.lens.fx, small.camera.lens.fx);
  EXPECT_EQ(coarse[1].image.rgb, small.image.rgb);
  EXPECT_TRUE(CoarseViews({&small, &small}).empty());
}

}  // namespace
}  // namespace vesta::gs
