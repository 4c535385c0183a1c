// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/settings/coarse_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "splatting/evaluate/evaluation.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

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

// Gaussians that are smaller than a pixel are as bright in a half-size view as in the full-size view.
TEST(CoarseViews, ShowSmallGaussiansAsBrightAsTheFullSizeDoes) {
  Scene scene = test::RingOfCameras(1, 160, 128, false);
  View& full = scene.views[0];
  full.image = Image(160, 128);
  SplatModel model = test::RandomModel(200, 0, 3);
  for (int k = 0; k < 3; ++k) {
    std::fill_n(model.data.begin() + (splat::kLogScale + k) * model.count, model.count, std::log(2e-3f));
  }
  std::fill_n(model.data.begin() + splat::kOpacity * model.count, model.count, -2.0f);  // little occlusion
  Renderer renderer({0, 0, 0}, 0.01);
  const auto mean = [&](const View& view, double eps2d) {
    View changed = view;
    changed.camera.eps2d = eps2d;
    const Image image = renderer.Render(model, changed);
    return std::accumulate(image.rgb.begin(), image.rgb.end(), 0.0) / static_cast<double>(image.rgb.size());
  };
  const View half = CoarseViews({&full})[0];
  const double brightness = mean(full, full.camera.eps2d);
  EXPECT_NEAR(mean(half, half.camera.eps2d) / brightness, 1, 0.1);
  EXPECT_GT(mean(half, full.camera.eps2d) / brightness, 2);
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
