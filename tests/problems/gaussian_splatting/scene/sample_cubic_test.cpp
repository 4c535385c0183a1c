// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "problems/gaussian_splatting/scene/undistort.h"

namespace vesta::gs {
namespace {

// Red rises to the right, green downwards, blue is a pattern.
Image Ramp(int width, int height) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto at = static_cast<std::size_t>(Index{y} * width + x);
      image.plane(0)[at] = 0.05f * static_cast<float>(x);
      image.plane(1)[at] = 0.04f * static_cast<float>(y);
      image.plane(2)[at] = (x * 7 + y * 3) % 5 == 0 ? 1.0f : 0.0f;
    }
  }
  return image;
}

TEST(SampleCubic, PassesThroughThePixels) {
  const Image image = Ramp(9, 7);
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 9; ++x) {
      const auto color = SampleCubic(image, x + 0.5, y + 0.5);
      for (int c = 0; c < 3; ++c) EXPECT_EQ(color[static_cast<std::size_t>(c)], image.plane(c)[y * 9 + x]);
    }
  }
}

TEST(SampleCubic, IsExactWhereColoursChangeLinearly) {
  const Image image = Ramp(9, 7);
  for (double u = 1.5; u <= 7.5; u += 0.3) {
    for (double v = 1.5; v <= 5.5; v += 0.3) {
      const auto color = SampleCubic(image, u, v);
      EXPECT_NEAR(color[0], 0.05 * (u - 0.5), 1e-6);
      EXPECT_NEAR(color[1], 0.04 * (v - 0.5), 1e-6);
    }
  }
}

TEST(SampleCubic, GoesOnAsTheBorderDoes) {
  const Image image = Ramp(9, 7);
  EXPECT_EQ(SampleCubic(image, -1e9, 3.5)[0], 0);
  EXPECT_EQ(SampleCubic(image, 1e9, 3.5)[0], image.plane(0)[8]);
  EXPECT_EQ(SampleCubic(image, 4.5, 1e9)[1], image.plane(1)[6 * 9]);
}

}  // namespace
}  // namespace vesta::gs
