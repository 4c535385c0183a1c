// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/scene/undistort.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/problems/gaussian_splatting/model/distort.h"

namespace vesta::gs {
namespace {

const Camera kCamera{320, 240, {.fx = 200, .fy = 202, .cx = 158, .cy = 123}};
const Distortion kBarrel{.radial = {-0.2, 0.05}, .tangential = {0.002, -0.001}};
const Distortion kPincushion{.radial = {0.15, 0.02}};
const Distortion kFisheye{.is_fisheye = true, .radial = {0.03, -0.01, 0.004, -0.001}};

// Where the photograph has pixel (u, v) of the pinhole's image.
std::array<double, 2> Source(const Camera& camera, const Distortion& lens, const Camera& pinhole, double u, double v) {
  const auto at = Distort(lens, (u - pinhole.lens.cx) / pinhole.lens.fx, (v - pinhole.lens.cy) / pinhole.lens.fy);
  return {camera.lens.fx * at[0] + camera.lens.cx, camera.lens.fy * at[1] + camera.lens.cy};
}

bool IsWithin(const Camera& camera, const std::array<double, 2>& at, double slack) {
  return at[0] >= 0.5 - slack && at[0] <= camera.width - 0.5 + slack && at[1] >= 0.5 - slack &&
         at[1] <= camera.height - 0.5 + slack;
}

TEST(PinholeOf, SeesNothingBeyondThePhotograph) {
  for (const Distortion& lens : {kBarrel, kPincushion, kFisheye}) {
    const Camera pinhole = PinholeOf(kCamera, lens).value();
    EXPECT_EQ(pinhole.lens.fx, kCamera.lens.fx);
    EXPECT_EQ(pinhole.lens.fy, kCamera.lens.fy);
    for (int y = 0; y < pinhole.height; ++y) {
      for (int x = 0; x < pinhole.width; ++x) {
        EXPECT_TRUE(IsWithin(kCamera, Source(kCamera, lens, pinhole, x + 0.5, y + 0.5), 0.03)) << x << ", " << y;
      }
    }
  }
}

// Two more pixels on any side would reach the outermost pixels or beyond. Rounding may lose one.
TEST(PinholeOf, SeesAllItCan) {
  for (const Distortion& lens : {kBarrel, kPincushion, kFisheye}) {
    const Camera pinhole = PinholeOf(kCamera, lens).value();
    const auto leaves = [&](double u, double v) {
      return !IsWithin(kCamera, Source(kCamera, lens, pinhole, u, v), -2);
    };
    bool left = false, right = false, top = false, bottom = false;
    for (int y = 0; y < pinhole.height; ++y) {
      left |= leaves(-1.5, y + 0.5);
      right |= leaves(pinhole.width + 1.5, y + 0.5);
    }
    for (int x = 0; x < pinhole.width; ++x) {
      top |= leaves(x + 0.5, -1.5);
      bottom |= leaves(x + 0.5, pinhole.height + 1.5);
    }
    EXPECT_TRUE(left) << pinhole.width << " x " << pinhole.height;
    EXPECT_TRUE(right);
    EXPECT_TRUE(top);
    EXPECT_TRUE(bottom);
  }
}

TEST(PinholeOf, IsTheCameraWhereNothingIsBent) {
  const Camera same = PinholeOf(kCamera, {}).value();
  EXPECT_TRUE(same.width == 320 && same.height == 240 && same.lens.cx == 158);
  const Camera nearly = PinholeOf(kCamera, {.radial = {1e-12}}).value();
  EXPECT_TRUE(nearly.width == 320 && nearly.height == 240) << nearly.width << " x " << nearly.height;
  EXPECT_NEAR(nearly.lens.cx, 158, 0.03);
  EXPECT_NEAR(nearly.lens.cy, 123, 0.03);
}

// A fisheye of 180 degrees, which no pinhole can cover.
TEST(PinholeOf, OfAWideFisheyeIsAtMostTwiceAsLarge) {
  const Camera wide{400, 400, {.fx = 400 / M_PI, .fy = 400 / M_PI, .cx = 200, .cy = 200}};
  const Camera pinhole = PinholeOf(wide, {.is_fisheye = true}).value();
  EXPECT_EQ(pinhole.width, 801);
  EXPECT_EQ(pinhole.height, 801);
  EXPECT_TRUE(IsWithin(wide, Source(wide, {.is_fisheye = true}, pinhole, 0.5, 0.5), 0.03));
}

// The distorted radius grows up to 0.577 and then falls; the pinhole covers only the inner part.
TEST(PinholeOf, KeepsToWhereTheLensDoesNotFold) {
  const Distortion folds{.radial = {-1}};
  const double radius = 1 / std::sqrt(3.0);
  const Camera pinhole = PinholeOf({320, 240, {.fx = 150, .fy = 150, .cx = 160, .cy = 120}}, folds).value();
  const double x = pinhole.lens.cx / 150, y = pinhole.lens.cy / 150;
  EXPECT_LE(std::hypot(x, y), radius + 0.02);
  EXPECT_GE(std::hypot(x, y), radius - 0.02);
}

TEST(PinholeOf, IsNoneWhereHardlyAnythingIsSeen) {
  EXPECT_FALSE(PinholeOf(kCamera, {.radial = {-1000}}));
  EXPECT_FALSE(PinholeOf(kCamera, {.radial = {1e300, 1e300}}));
  EXPECT_FALSE(PinholeOf(kCamera, {.radial = {NAN}}));
  EXPECT_FALSE(PinholeOf(kCamera, {.tangential = {0, INFINITY}}));
  EXPECT_FALSE(PinholeOf(kCamera, {.tangential = {300, 0}}));
  Camera off_axis = kCamera;
  off_axis.lens.cx = 400;
  EXPECT_FALSE(PinholeOf(off_axis, kBarrel)) << "the axis is not in the photograph";
  const Camera one{1, 1, {.fx = 1, .fy = 1, .cx = 0.5, .cy = 0.5}};
  EXPECT_TRUE(!PinholeOf(one, kBarrel) || PinholeOf(one, kBarrel)->width >= 1);
}

TEST(Undistort, IsTheInverseOfDistort) {
  for (const Distortion& lens :
       {kBarrel, kPincushion, kFisheye, Distortion{.radial = {0.3, -0.1, 0.02, 0.4, -0.05, 0.01}}}) {
    for (double x = -0.9; x <= 0.9; x += 0.15) {
      for (double y = -0.6; y <= 0.6; y += 0.15) {
        const auto bent = Distort(lens, x, y);
        const auto back = test::Undistort(lens, bent[0], bent[1]);
        ASSERT_TRUE(back) << x << ", " << y;
        EXPECT_NEAR((*back)[0], x, 1e-10);
        EXPECT_NEAR((*back)[1], y, 1e-10);
      }
    }
  }
  EXPECT_FALSE(test::Undistort({.radial = {-1}}, 0.5, 0))
      << "the lens does not reach there: its largest radius is 0.385";
}

// Smooth colours that differ everywhere.
Image Waves(const Camera& camera) {
  Image image(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto at = static_cast<std::size_t>(Index{y} * camera.width + x);
      image.plane(0)[at] = static_cast<float>(0.5 + 0.4 * std::sin(0.11 * x + 0.05 * y));
      image.plane(1)[at] = static_cast<float>(0.5 + 0.4 * std::sin(0.13 * y - 0.03 * x));
      image.plane(2)[at] = static_cast<float>(x) / static_cast<float>(camera.width);
    }
  }
  return image;
}

// Neighbours are missing at the border, so interpolation costs a sixteenth of the difference between two pixels, twice.
TEST(UndistortImage, UndoesWhatALensHasDone) {
  const Image truth = Waves(kCamera);
  for (const Distortion& lens : {kBarrel, kPincushion, kFisheye}) {
    const Camera bent = test::DistortedCamera(kCamera, lens);
    const Camera pinhole = PinholeOf(bent, lens).value();
    const Image image = UndistortImage(test::DistortImage(truth, kCamera, bent, lens), bent, lens, pinhole);
    ASSERT_GT(image.width, 160);
    const double left = kCamera.lens.cx - pinhole.lens.cx, top = kCamera.lens.cy - pinhole.lens.cy;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const auto at = static_cast<std::size_t>(Index{y} * image.width + x);
        EXPECT_NEAR(image.plane(0)[at], 0.5 + 0.4 * std::sin(0.11 * (x + left) + 0.05 * (y + top)), 7e-3);
        EXPECT_NEAR(image.plane(1)[at], 0.5 + 0.4 * std::sin(0.13 * (y + top) - 0.03 * (x + left)), 7e-3);
        EXPECT_NEAR(image.plane(2)[at], (x + left) / kCamera.width, 2e-3);
      }
    }
  }
}

// One pixel of the result covers three. Stripes of one pixel become their mean; single samples would be black or white.
TEST(UndistortImage, AveragesWhereItShrinks) {
  const Camera camera{300, 300, {.fx = 300, .fy = 300, .cx = 150, .cy = 150}};
  const Camera pinhole{100, 100, {.fx = 100, .fy = 100, .cx = 50, .cy = 50}};
  Image stripes(300, 300);
  for (std::size_t i = 0; i < stripes.rgb.size(); ++i) stripes.rgb[i] = i % 2 == 0 ? 1.0f : 0.0f;
  const Image image = UndistortImage(stripes, camera, {.radial = {1e-9}}, pinhole);
  for (const float value : image.rgb) EXPECT_NEAR(value, 0.5, 0.17);
}

// Red increases to the right, green downwards; blue is a pattern.
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
