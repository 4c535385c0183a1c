// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "splatting/render/surface.h"

namespace vesta::gs {
namespace {

float Sum(const Image& image, std::size_t pixel) {
  return image.plane(0)[pixel] + image.plane(1)[pixel] + image.plane(2)[pixel];
}

TEST(SurfaceColors, NearIsLighterThanFarAndNothingIsBlack) {
  const Image image = DepthColors({5, 1, {0, 0.01f, 1, 3, 1e6f}}, 1);
  EXPECT_EQ(Sum(image, 0), 0);
  for (std::size_t p = 1; p < 4; ++p) EXPECT_GT(Sum(image, p), Sum(image, p + 1)) << p;
  EXPECT_GT(Sum(image, 4), 0);
  // The middle of the scale: the third of five colours.
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
