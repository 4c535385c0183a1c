// SPDX-License-Identifier: Apache-2.0
#include "splatting/render/surface.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "splatting/render/look.h"

namespace vesta::gs {
namespace {

constexpr int kSide = 65;
constexpr std::size_t kMiddle = kSide * (kSide / 2) + kSide / 2;
const Camera kCamera{kSide, kSide, {60, 60, kSide / 2.0, kSide / 2.0}};

View ViewAlongZ() {
  View view;
  view.camera = kCamera;
  return view;
}

float LogitOf(double opacity) { return static_cast<float>(std::log(opacity / (1 - opacity))); }

struct Disc {
  Point3 mean;
  std::array<double, 3> deviation;
  std::array<double, 4> quaternion{1, 0, 0, 0};
  double opacity = 0.99;
};

SplatModel ModelOf(const std::vector<Disc>& discs) {
  SplatModel model;
  model.Resize(1, static_cast<Index>(discs.size()));
  for (std::size_t d = 0; d < discs.size(); ++d) {
    const auto i = static_cast<Index>(d);
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(k);
      model.attribute(splat::kMean + k)[i] = static_cast<float>(discs[d].mean[at]);
      model.attribute(splat::kLogScale + k)[i] = static_cast<float>(std::log(discs[d].deviation[at]));
      model.attribute(splat::kSh + 3 + k)[i] = 3;  // direction-dependent colours, negative in some directions
    }
    for (int k = 0; k < 4; ++k) {
      model.attribute(splat::kQuaternion + k)[i] = static_cast<float>(discs[d].quaternion[static_cast<std::size_t>(k)]);
    }
    model.attribute(splat::kOpacity)[i] = LogitOf(discs[d].opacity);
  }
  return model;
}

// Adjacent discs cover the plane through (0, 0, 5) with normal (0, -sin, -cos) of the tilt. The camera at the origin
// looks along z.
SplatModel Plane(double tilt) {
  std::vector<Disc> discs;
  for (int i = -40; i <= 40; ++i) {
    for (int j = -40; j <= 40; ++j) {
      const double x = 0.2 * i, along = 0.2 * j;
      discs.push_back({{x, along * std::cos(tilt), 5 - along * std::sin(tilt)},
                       {0.25, 0.25, 0.001},
                       {std::cos(tilt / 2), -std::sin(tilt / 2), 0, 0}});
    }
  }
  return ModelOf(discs);
}

// Depth from the equation of the plane.
double DepthOfPlane(double tilt, std::size_t pixel) {
  const std::size_t row = pixel / kSide;
  const double v = (static_cast<double>(row) + 0.5 - kSide / 2.0) / 60;
  return 5 / (1 + v * std::tan(tilt));
}

TEST(Surface, DepthOfAPlaneIsKnown) {
  for (const DepthKind kind : {DepthKind::kMean, DepthKind::kMedian}) {
    for (const double tilt : {0.0, 0.5, -0.5}) {
      const DepthImage image = SurfaceRenderer(0.01).Depth(Plane(tilt), ViewAlongZ(), kind);
      ASSERT_EQ(image.depth.size(), static_cast<std::size_t>(kSide * kSide));
      for (std::size_t p = 0; p < image.depth.size(); ++p) {
        const double expected = DepthOfPlane(tilt, p);
        EXPECT_NEAR(static_cast<double>(image.depth[p]), expected, (tilt == 0 ? 1e-5 : 0.01) * expected) << p;
      }
    }
  }
}

TEST(Surface, NormalsOfAPlaneAreKnown) {
  for (const double tilt : {0.0, 0.5, -0.5}) {
    const NormalImage image = SurfaceRenderer(0.01).Normals(Plane(tilt), ViewAlongZ());
    for (std::size_t p = 0; p < kSide * kSide; ++p) {
      EXPECT_NEAR(static_cast<double>(image.normals[p]), 0, 1e-4);
      EXPECT_NEAR(static_cast<double>(image.normals[kSide * kSide + p]), std::sin(tilt), 1e-4)
          << "the y axis points up";
      EXPECT_NEAR(static_cast<double>(image.normals[2 * kSide * kSide + p]), std::cos(tilt), 1e-4);
    }
  }
}

// Depth and normal are in camera coordinates: a camera at the side sees the plane's normal point right.
TEST(Surface, IsSeenFromTheCamera) {
  const View aside = LookingAt(kCamera, {-4, 0, 1}, {0, 0, 5}, {0, -1, 0});
  const SplatModel plane = Plane(0);
  SurfaceRenderer renderer(0.01);
  EXPECT_NEAR(static_cast<double>(renderer.Depth(plane, aside).depth[kMiddle]), std::sqrt(32.0), 0.05);
  const NormalImage normals = renderer.Normals(plane, aside);
  EXPECT_NEAR(static_cast<double>(normals.normals[kMiddle]), std::sqrt(0.5), 1e-4);
  EXPECT_NEAR(static_cast<double>(normals.normals[2 * kSide * kSide + kMiddle]), std::sqrt(0.5), 1e-4);
  const View behind = LookingAt(kCamera, {0, 0, 9}, {0, 0, 5}, {0, -1, 0});
  EXPECT_NEAR(static_cast<double>(renderer.Normals(plane, behind).normals[2 * kSide * kSide + kMiddle]), 1, 1e-4);
}

// Depth is blended with the weights of colour: one half-transparent disc before another.
TEST(Surface, DepthIsTheMeanByWeight) {
  const std::array<double, 3> wide{2, 2, 0.01};
  const SplatModel model = ModelOf({{{0, 0, 2}, wide, {1, 0, 0, 0}, 0.6}, {{0, 0, 4}, wide, {1, 0, 0, 0}, 0.5}});
  const DepthImage image = SurfaceRenderer(0.01).Depth(model, ViewAlongZ());
  EXPECT_NEAR(static_cast<double>(image.depth[kMiddle]), (0.6 * 2 + 0.4 * 0.5 * 4) / (0.6 + 0.4 * 0.5), 1e-4);
}

// The median depth belongs to the first Gaussian behind which less than half of the light remains.
TEST(Surface, MedianDepthIsThatOfOneGaussian) {
  const std::array<double, 3> wide{2, 2, 0.01};
  SurfaceRenderer renderer(0.01);
  const auto depth = [&](double first, double second) {
    const SplatModel model = ModelOf({{{0, 0, 2}, wide, {1, 0, 0, 0}, first},
                                      {{0, 0, 4}, wide, {1, 0, 0, 0}, second},
                                      {{0, 0, 5}, wide, {1, 0, 0, 0}, 0.4}});
    return renderer.Depth(model, ViewAlongZ(), DepthKind::kMedian).depth[kMiddle];
  };
  EXPECT_NEAR(depth(0.6, 0.5), 2, 1e-5);
  EXPECT_NEAR(depth(0.4, 0.5), 4, 1e-5);
  EXPECT_NEAR(depth(0.2, 0.3), 5, 1e-5) << "0.8 * 0.7 is more than 0.5, and 0.8 * 0.7 * 0.6 less";
  EXPECT_EQ(depth(0.05, 0.05), 0) << "more than half of the light is background";
}

TEST(Surface, IsNoneWhereHalfIsBackground) {
  const std::array<double, 3> wide{2, 2, 0.01};
  SurfaceRenderer renderer(0.01);
  for (const double opacity : {0.49, 0.51}) {
    const SplatModel model = ModelOf({{{0, 0, 3}, wide, {1, 0, 0, 0}, opacity}});
    EXPECT_EQ(renderer.Depth(model, ViewAlongZ()).depth[kMiddle] > 0, opacity > 0.5);
    EXPECT_EQ(renderer.Normals(model, ViewAlongZ()).normals[2 * kSide * kSide + kMiddle] > 0, opacity > 0.5);
  }
  const SplatModel beside = ModelOf({{{100, 0, 3}, wide}});
  for (const float depth : renderer.Depth(beside, ViewAlongZ()).depth) EXPECT_EQ(depth, 0);
}

// A sphere and a needle contribute to the depth but not to the normal.
TEST(Surface, BallsAndNeedlesHaveNoNormal) {
  const SplatModel model = ModelOf({{{0, 0, 2}, {1, 1, 1}, {0.9, 0.3, 0.1, 0}, 0.4},
                                    {{0, 0, 3}, {3, 0.5, 0.5}, {0.9, 0, 0.2, 0.1}, 0.4},
                                    {{0, 0, 4}, {3, 3, 0.01}}});
  const NormalImage image = SurfaceRenderer(0.01).Normals(model, ViewAlongZ());
  EXPECT_NEAR(static_cast<double>(image.normals[2 * kSide * kSide + kMiddle]), 1, 1e-5);
}

float Sum(const Image& image, std::size_t pixel) {
  return image.plane(0)[pixel] + image.plane(1)[pixel] + image.plane(2)[pixel];
}

TEST(SurfaceColors, NearIsLighterThanFarAndNothingIsBlack) {
  const Image image = DepthColors({5, 1, {0, 0.01f, 1, 3, 1e6f}}, 1);
  EXPECT_EQ(Sum(image, 0), 0);
  for (std::size_t p = 1; p < 4; ++p) EXPECT_GT(Sum(image, p), Sum(image, p + 1)) << p;
  EXPECT_GT(Sum(image, 4), 0);
  // The middle of the scale is the third of five colours.
  EXPECT_FLOAT_EQ(image.plane(1)[2], 0.52f);
}

TEST(SurfaceColors, NormalsAreColoursFromMinusOneToOne) {
  const Image image = NormalColors({3, 1, {0, 0, 1, 0, -1, 0, 1, 0, 0}});
  const auto color = [&](std::size_t p) { return std::array{image.plane(0)[p], image.plane(1)[p], image.plane(2)[p]}; };
  EXPECT_EQ(color(0), (std::array{0.5f, 0.5f, 1.0f}));
  EXPECT_EQ(color(1), (std::array{0.5f, 0.0f, 0.5f}));
  EXPECT_EQ(color(2), (std::array{1.0f, 0.5f, 0.5f}));
  EXPECT_EQ(Sum(NormalColors({1, 1, {0, 0, 0}}), 0), 0);
}

}  // namespace

}  // namespace vesta::gs
