// SPDX-License-Identifier: Apache-2.0
#include "kernels/image/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kernels/core/check.h"
#include "tests/kernels/image/reference.h"

namespace vesta {
namespace {

TEST(Metrics, QuantizesToTheNearestOf256) {
  EXPECT_EQ(QuantizeTo8Bit(-3.0f), 0.0f);
  EXPECT_EQ(QuantizeTo8Bit(1.5f), 1.0f);
  EXPECT_EQ(QuantizeTo8Bit(0.49f / 255.0f), 0.0f);
  EXPECT_EQ(QuantizeTo8Bit(0.51f / 255.0f), 1.0f / 255.0f);
  for (int k = 0; k < 256; ++k) {
    const float level = static_cast<float>(k) / 255.0f;
    EXPECT_EQ(QuantizeTo8Bit(level), level);
  }
  EXPECT_TRUE(std::isnan(QuantizeTo8Bit(std::numeric_limits<float>::quiet_NaN())));
}

TEST(Metrics, AreThoseOfDirectSumsOnQuantisedImages) {
  const ImageShape shape{.width = 23, .height = 18};
  const auto truth = reference::RandomImage<float>(shape, 51, -0.2, 1.2);
  const auto rendered = reference::RandomImage<float>(shape, 52, -0.2, 1.2);
  std::vector<double> x, y;
  double squared = 0.0, ssim = 0.0;
  for (Index i = 0; i < shape.NumValues(); ++i) {
    x.push_back(std::round(255.0 * std::clamp(static_cast<double>(rendered[i]), 0.0, 1.0)) / 255.0);
    y.push_back(std::round(255.0 * std::clamp(static_cast<double>(truth[i]), 0.0, 1.0)) / 255.0);
    squared += (x.back() - y.back()) * (x.back() - y.back());
  }
  for (const double d : reference::Dissimilarity(x, y, shape)) ssim += 1.0 - d;
  const auto count = static_cast<double>(shape.NumValues());
  ImageQualityMeter meter;
  for (int repeat = 0; repeat < 2; ++repeat) {
    const ImageQuality quality = meter.Measure(rendered, truth, shape);
    EXPECT_NEAR(quality.psnr, 10.0 * std::log10(count / squared), 1e-6);
    EXPECT_NEAR(quality.ssim, ssim / count, 1e-6);
  }
}

TEST(Metrics, OfAnImageWithItselfAreInfinityAndOne) {
  const ImageShape shape{.width = 7, .height = 6};
  const auto image = reference::RandomImage<float>(shape, 53);
  const ImageQuality quality = ImageQualityMeter().Measure(image, image, shape);
  EXPECT_EQ(quality.psnr, std::numeric_limits<double>::infinity());
  EXPECT_EQ(quality.ssim, 1.0);
}

TEST(Metrics, RefuseWrongSizes) {
  HostBuffer<float> image(12), small(5);
  EXPECT_THROW(ImageQualityMeter().Measure(image, small, {.width = 2, .height = 2}), Error);
}

}  // namespace
}  // namespace vesta
