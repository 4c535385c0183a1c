// SPDX-License-Identifier: Apache-2.0
#include "splatting/points/plane_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/core/parallel.h"
#include "tests/splatting/points/plane_views.h"

namespace vesta::gs {
namespace {
using namespace test;

class OnPlane : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(PlaneSweep, OnPlane, testing::Values(0.0, 0.5));

TEST_P(OnPlane, PointsLieOnItWithItsColors) {
  const Plane plane{GetParam()};
  const PointCloud points = PointsByPlaneSweep(TexturedViews(plane, 5), 1000, 1);
  ASSERT_GT(points.size(), 800);
  int near = 0;
  double error = 0;
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    const auto& [x, y, z] = points.positions[i];
    near += std::abs(z - plane.Height(x)) < 0.02 * 4 ? 1 : 0;
    for (int c = 0; c < 3; ++c) {
      error += std::abs(double{points.colors[i][static_cast<std::size_t>(c)] - Texture(x, y, c)});
    }
  }
  const auto count = static_cast<double>(points.size());
  EXPECT_GT(near / count, 0.95);
  EXPECT_LT(error / (3 * count), 0.05);
}

TEST(PlaneSweep, DependsOnTheSeedAndNotOnThreads) {
  const std::vector<View> views = TexturedViews({}, 3);
  const PointCloud points = PointsByPlaneSweep(views, 200, 7);
  ASSERT_EQ(points.size(), 200);
  EXPECT_NE(PointsByPlaneSweep(views, 200, 8).positions, points.positions);
  SetNumThreads(1);
  const PointCloud alone = PointsByPlaneSweep(views, 200, 7);
  SetNumThreads(0);
  EXPECT_EQ(alone.positions, points.positions);
  EXPECT_EQ(alone.colors, points.colors);
}

TEST(PlaneSweep, MaskedPixelsGiveNoPoints) {
  std::vector<View> views = TexturedViews({}, 4);
  for (View& view : views) {  // masks out the plane's part with x < 0.6
    view.image.mask.resize(view.image.num_pixels());
    for (int k = 0; k < kPlaneWidth * kPlaneHeight; ++k) {
      const double x = (k % kPlaneWidth + 0.5 - 60) / 100 * 4 - view.translation[0];
      view.image.mask[static_cast<std::size_t>(k)] = x < 0.6 ? 0 : 1;
    }
  }
  const PointCloud points = PointsByPlaneSweep(views, 300, 1);
  ASSERT_GT(points.size(), 100);
  const auto is_masked = [](const std::array<float, 3>& p) { return p[0] < 0.55f; };
  EXPECT_LE(std::ranges::count_if(points.positions, is_masked), points.size() / 50);
}

TEST(PlaneSweep, TestViewsAreNotUsed) {
  std::vector<View> views = TexturedViews({}, 4);
  const PointCloud points = PointsByPlaneSweep(views, 100, 1);
  View test = views[0];
  test.role = ViewRole::kTest;
  std::ranges::fill(test.image.rgb, 0.5f);
  views.push_back(test);
  EXPECT_EQ(PointsByPlaneSweep(views, 100, 1).positions, points.positions);
}

TEST(PlaneSweep, WithoutTextureOverlapOrMotionThereAreNoPoints) {
  const std::vector<View> flat = ViewsOf({}, 4, [](double, double, int) { return 0.4f; });
  EXPECT_EQ(PointsByPlaneSweep(flat, 100, 1).size(), 0);
  // Stripes along the baseline look the same at every depth, except where other depths are outside the images.
  const std::vector<View> striped = ViewsOf({}, 4, [](double, double y, int c) { return Texture(0, y, c); });
  EXPECT_LT(PointsByPlaneSweep(striped, 1000, 1).size(), 8000 / 20) << "of 8000 pixels";
  std::vector<View> views = TexturedViews({}, 2);
  EXPECT_EQ(PointsByPlaneSweep({views[0]}, 100, 1).size(), 0);
  EXPECT_EQ(PointsByPlaneSweep({}, 100, 1).size(), 0);
  views[1] = views[0];
  EXPECT_EQ(PointsByPlaneSweep(views, 100, 1).size(), 0);
  views = TexturedViews({}, 2);
  views[1].rotation = {-1, 0, 0, 0, 1, 0, 0, 0, -1};
  EXPECT_EQ(PointsByPlaneSweep(views, 100, 1).size(), 0);
}

TEST(PlaneSweep, ImagesOfAFewPixelsGiveNoPoints) {
  std::vector<View> views(3);
  for (std::size_t k = 0; k < 3; ++k) {
    views[k].camera = {.width = 2, .height = 1, .lens = {.fx = 2, .fy = 2, .cx = 1, .cy = 0.5}};
    views[k].translation = {0.1 * static_cast<double>(k), 0, 0};
    views[k].image = Image(2, 1);
    views[k].image.rgb = {0, 1, 0, 1, 0, 1};
  }
  EXPECT_EQ(PointsByPlaneSweep(views, 50, 1).size(), 0);
}

}  // namespace
}  // namespace vesta::gs
