#include "problems/gaussian_splatting/cameras/affine_color.h"

#include <gtest/gtest.h>

#include "kernels/core/error.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

constexpr ImageShape kShape{13, 7};

HostSpan<float> Span(std::vector<float>& image) { return {image.data(), static_cast<Index>(image.size())}; }

std::vector<float> RandomImage(std::uint64_t seed) {
  test::Random random(seed);
  std::vector<float> image(static_cast<std::size_t>(kShape.NumValues()));
  for (float& value : image) value = static_cast<float>(random.Uniform(0.1, 0.9));
  return image;
}

constexpr AffineColor kExposure{{0.8, 1.2, 1.05}, {0.02, -0.1, 0}};

TEST(AffineColor, ActsOnEachChannelAndIsFoundAgain) {
  std::vector<float> rendered = RandomImage(1), truth = rendered;
  kExposure.Apply(Span(truth));
  const auto plane = static_cast<std::size_t>(kShape.PlaneSize());
  EXPECT_FLOAT_EQ(truth[5], 0.8f * rendered[5] + 0.02f);
  EXPECT_FLOAT_EQ(truth[plane + 5], 1.2f * rendered[plane + 5] - 0.1f);
  EXPECT_FLOAT_EQ(truth[2 * plane + 5], 1.05f * rendered[2 * plane + 5]);
  const AffineColor found = FitAffineColor(Span(rendered), Span(truth), kShape);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(found.gain[c], kExposure.gain[c], 1e-6);
    EXPECT_NEAR(found.offset[c], kExposure.offset[c], 1e-6);
  }
}

// No other exposure comes closer.
TEST(AffineColor, MinimisesTheSquaredError) {
  std::vector<float> rendered = RandomImage(2), truth = RandomImage(3);
  const auto error = [&](const AffineColor& color) {
    std::vector<float> shown = rendered;
    color.Apply(Span(shown));
    double sum = 0;
    for (std::size_t i = 0; i < shown.size(); ++i) sum += (shown[i] - truth[i]) * (shown[i] - truth[i]);
    return sum;
  };
  const AffineColor best = FitAffineColor(Span(rendered), Span(truth), kShape);
  for (std::size_t c = 0; c < 3; ++c) {
    for (const double step : {-0.01, 0.01}) {
      AffineColor gain = best, offset = best;
      gain.gain[c] += step, offset.offset[c] += step;
      EXPECT_GT(error(gain), error(best));
      EXPECT_GT(error(offset), error(best));
    }
  }
}

TEST(AffineColor, OfOneColourIsAnOffset) {
  std::vector<float> rendered(static_cast<std::size_t>(kShape.NumValues()), 0.25f), truth = RandomImage(4);
  const AffineColor found = FitAffineColor(Span(rendered), Span(truth), kShape);
  double mean = 0;
  for (int i = 0; i < kShape.PlaneSize(); ++i) mean += static_cast<double>(truth[static_cast<std::size_t>(i)]);
  EXPECT_EQ(found.gain[0], 1);
  EXPECT_NEAR(found.offset[0], mean / static_cast<double>(kShape.PlaneSize()) - 0.25, 1e-6);
  EXPECT_THROW(FitAffineColor(Span(rendered), Span(truth), {13, 8}), Error);
}

}  // namespace
}  // namespace vesta::gs
