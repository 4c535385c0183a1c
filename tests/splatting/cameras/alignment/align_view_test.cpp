// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/alignment/align_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "kernels/core/error.h"
#include "tests/splatting/cameras/perturbed_view.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

constexpr double kDistance = 3;  // of the ring's cameras from its centre

class AlignedToTheTruth : public testing::Test {
 protected:
  SplatModel model_ = test::RandomModel(300, 1, 7);
  View view_ = test::RingWithImages(model_, 3, 160, 120).views[1];
  AlignOptions options_{.near = 0.01};

  // The remaining error in pixels.
  double Left(const Alignment& alignment, const View& start) const {
    return test::LargestShift(model_, MovedView(start, alignment.found.motion), view_);
  }
};

TEST_F(AlignedToTheTruth, CamerasComeBackToAThousandthOfAPixel) {
  for (const double degrees : {0.1, 0.3, 1.0}) {
    for (const double part : {0.003, 0.01}) {
      for (const std::uint64_t seed : {1, 2}) {
        SCOPED_TRACE(testing::Message() << degrees << " degrees, " << part << " of the distance, seed " << seed);
        const View start = test::PerturbedView(view_, test::RandomMotion(degrees, part * kDistance, seed));
        const double before = test::LargestShift(model_, start, view_);
        const Alignment alignment = AlignView(model_, start, options_);
        EXPECT_EQ(alignment.status, AlignStatus::kConverged) << ToString(alignment.status);
        EXPECT_GT(before, 0.1);
        EXPECT_LT(Left(alignment, start), 3e-4);
        EXPECT_LT(alignment.cost_after, alignment.cost_before);
      }
    }
  }
}

TEST_F(AlignedToTheTruth, ExposuresAreFoundWithTheCamera) {
  const AffineColor exposure{{0.8, 1.2, 0.9}, {0.05, -0.02, 0.01}};
  exposure.Apply(HostSpan<float>{view_.image.rgb.data(), static_cast<Index>(view_.image.rgb.size())});
  const View start = test::PerturbedView(view_, test::RandomMotion(0.3, 0.003 * kDistance, 3));
  options_.free.color = true;
  const Alignment alignment = AlignView(model_, start, options_);
  EXPECT_TRUE(alignment.is_found()) << ToString(alignment.status);
  EXPECT_LT(Left(alignment, start), 1e-3);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(alignment.found.color.gain[c], exposure.gain[c], 1e-4);
    EXPECT_NEAR(alignment.found.color.offset[c], exposure.offset[c], 1e-4);
  }
  // Fitting the exposure alone does not move a correct camera.
  options_.free.pose = false;
  const Alignment color_alone = AlignView(model_, view_, options_);
  EXPECT_EQ(color_alone.found.motion.Angle(), 0);
  EXPECT_NEAR(color_alone.found.color.gain[1], exposure.gain[1], 1e-4);
}

// Small Gaussians do not overlap with their displaced images: 3 degrees are 13 pixels.
TEST(AlignView, ReachesFurtherByCoarseImages) {
  SplatModel model = test::RandomModel(1500, 0, 8);
  for (int k = 0; k < 3; ++k) {
    float* const log_scale = model.attribute(splat::kLogScale + k);
    std::transform(log_scale, log_scale + model.count, log_scale, [](float value) { return value - 1.5f; });
  }
  const View view = test::RingWithImages(model, 3, 160, 120).views[1];
  const View start = test::PerturbedView(view, test::RandomMotion(3, 0, 4));
  const auto left = [&](int levels) {
    const Alignment alignment = AlignView(model, start, {.near = 0.01, .levels = levels});
    return test::LargestShift(model, MovedView(start, alignment.found.motion), view);
  };
  EXPECT_LT(left(3), 1e-3);
  EXPECT_GT(left(1), 1);
}

// Without usable information, views are not moved.
class NothingToAlignBy : public AlignedToTheTruth {
 protected:
  void ExpectUnmoved(const View& view, AlignStatus status) {
    for (const bool color : {false, true}) {
      options_.free.color = color;
      const Alignment alignment = AlignView(model_, view, options_);
      EXPECT_EQ(alignment.status, status) << ToString(alignment.status);
      EXPECT_FALSE(alignment.is_found());
      EXPECT_EQ(alignment.found.motion.Angle(), 0);
      for (const double t : alignment.found.motion.translation) EXPECT_EQ(t, 0);
      EXPECT_EQ(alignment.found.color.gain, AffineColor().gain);
      EXPECT_EQ(alignment.found.color.offset, AffineColor().offset);
    }
  }
};

TEST_F(NothingToAlignBy, FromACameraThatLooksAway) {
  View view = view_;
  for (std::size_t k = 0; k < 3; ++k) {
    // Rotates by 180 degrees about the y axis.
    view.rotation[k] *= -1, view.rotation[6 + k] *= -1;
  }
  view.translation[0] *= -1, view.translation[2] *= -1;
  ExpectUnmoved(view, AlignStatus::kSeesNothing);
}

TEST_F(NothingToAlignBy, InABlackImageOrAGreyOne) {
  View view = view_;
  for (const float grey : {0.0f, 0.5f}) {
    std::fill(view.image.rgb.begin(), view.image.rgb.end(), grey);
    ExpectUnmoved(view, AlignStatus::kFlatImage);
  }
}

TEST_F(NothingToAlignBy, InWhatIsNotFinite) {
  View nan_pixel = view_, infinite_pose = view_;
  nan_pixel.image.rgb[1000] = std::numeric_limits<float>::quiet_NaN();
  ExpectUnmoved(nan_pixel, AlignStatus::kNotFinite);
  infinite_pose.translation[1] = std::numeric_limits<double>::infinity();
  ExpectUnmoved(infinite_pose, AlignStatus::kNotFinite);
}

TEST_F(NothingToAlignBy, AtTheBestThereIs) {
  options_.max_iterations = 0;
  ExpectUnmoved(view_, AlignStatus::kNoGain);
}

TEST_F(NothingToAlignBy, InAnImageOfAnotherSize) {
  View view = view_;
  view.image = Image(80, 60);
  EXPECT_THROW(AlignView(model_, view, options_), Error);
  for (const int levels : {0, 17}) {
    options_.levels = levels;
    EXPECT_THROW(AlignView(model_, view_, options_), Error);
  }
}

// Images too small for a coarse level are aligned at full size.
TEST(AlignView, TakesSmallImages) {
  const SplatModel model = test::RandomModel(60, 0, 9);
  const View view = test::RingWithImages(model, 3, 33, 20).views[1];
  const View start = test::PerturbedView(view, test::RandomMotion(0.3, 0, 5));
  const Alignment alignment = AlignView(model, start, {.near = 0.01});
  EXPECT_TRUE(alignment.is_found());
  EXPECT_LT(test::LargestShift(model, MovedView(start, alignment.found.motion), view), 1e-3);
}

constexpr ImageShape kShape{32, 24};

HostSpan<float> Span(std::vector<float>& image) { return {image.data(), static_cast<Index>(image.size())}; }

std::vector<float> RandomImage(std::uint64_t seed) {
  vesta::test::Random random(seed);
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

// 10 % of the pixels show something else. Plain least squares would fit a gain 10 % too small.
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
