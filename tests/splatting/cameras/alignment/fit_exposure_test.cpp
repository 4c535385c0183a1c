// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "kernels/core/error.h"
#include "splatting/cameras/alignment/align_view.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

constexpr ImageShape kShape{32, 24};

HostSpan<float> Span(std::vector<float>& image) { return {image.data(), static_cast<Index>(image.size())}; }

std::vector<float> RandomImage(std::uint64_t seed) {
  test::Random random(seed);
  std::vector<float> image(static_cast<std::size_t>(kShape.NumValues()));
  for (float& value : image) value = static_cast<float>(random.Uniform(0.1, 0.9));
  return image;
}

constexpr AffineColor kExposure{{0.8, 1.2, 1.05}, {0.02, -0.1, 0}};

void ExpectNear(const AffineColor& found, const AffineColor& expected, double tolerance) {
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(found.gain[c], expected.gain[c], tolerance);
    EXPECT_NEAR(found.offset[c], expected.offset[c], tolerance);
  }
}

TEST(AffineColor, ActsOnEachChannel) {
  const std::vector<float> image = RandomImage(1);
  std::vector<float> exposed = image;
  kExposure.Apply(Span(exposed));
  const auto plane = static_cast<std::size_t>(kShape.PlaneSize());
  for (const std::size_t i : {std::size_t{0}, plane - 1}) {
    EXPECT_FLOAT_EQ(exposed[i], 0.8f * image[i] + 0.02f);
    EXPECT_FLOAT_EQ(exposed[plane + i], 1.2f * image[plane + i] - 0.1f);
    EXPECT_FLOAT_EQ(exposed[2 * plane + i], 1.05f * image[2 * plane + i]);
  }
}

TEST(FitExposure, FindsWhatWasApplied) {
  std::vector<float> rendered = RandomImage(2), truth = rendered;
  kExposure.Apply(Span(truth));
  ExpectNear(FitExposure(Span(rendered), Span(truth), kShape), kExposure, 1e-5);
}

// A tenth of the pixels show something else, which least squares would follow: its gain would be 10 % too small.
TEST(FitExposure, IsNotLedAstrayByWhatTheSplatLacks) {
  std::vector<float> rendered = RandomImage(3), truth = rendered;
  kExposure.Apply(Span(truth));
  const std::vector<float> other = RandomImage(4);
  for (std::size_t i = 0; i < truth.size(); i += 10) truth[i] = other[i];
  ExpectNear(FitExposure(Span(rendered), Span(truth), kShape), kExposure, 0.02);
}

TEST(FitExposure, OfOneColourFindsIt) {
  std::vector<float> rendered(static_cast<std::size_t>(kShape.NumValues()), 0.25f), truth = rendered;
  for (float& value : truth) value = 0.4f;
  const AffineColor found = FitExposure(Span(rendered), Span(truth), kShape);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(0.25 * found.gain[c] + found.offset[c], 0.4, 1e-3);
}

TEST(FitExposure, OfWhatIsNotFiniteIsNone) {
  std::vector<float> rendered = RandomImage(5), truth = RandomImage(6);
  truth[3] = std::numeric_limits<float>::quiet_NaN();
  ExpectNear(FitExposure(Span(rendered), Span(truth), kShape), {}, 0);
  EXPECT_THROW(FitExposure(Span(rendered), Span(truth), {32, 25}), Error);
}

}  // namespace
}  // namespace vesta::gs
