// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "splatting/cameras/alignment/align_view.h"
#include "splatting/evaluate/evaluation.h"
#include "tests/splatting/cameras/perturbed_view.h"

namespace vesta::gs {
namespace {

class AlignedEvaluationOfARing : public testing::Test {
 protected:
  AlignedEvaluationOfARing() {
    options_.near = NearPlane(scene_);
    for (View& view : scene_.views) {
      if (view.is_test()) view = test::PerturbedView(view, test::RandomMotion(0.5, 0.01, ++tests_));
    }
  }

  Evaluation Plain() const { return Renderer({0, 0, 0}, NearPlane(scene_)).Evaluate(model_, scene_); }

  SplatModel model_ = test::RandomModel(200, 1, 11);
  Scene scene_ = test::RingWithImages(model_, 10, 96, 72);
  AlignOptions options_;
  std::uint64_t tests_ = 0;
};

TEST_F(AlignedEvaluationOfARing, IsThatOfTheRightCameras) {
  ASSERT_EQ(tests_, 2u);
  const AlignedEvaluation aligned = EvaluateAligned(model_, scene_, options_);
  const Evaluation plain = Plain();
  EXPECT_EQ(aligned.whole.views, 2);
  EXPECT_EQ(aligned.not_found, 0);
  EXPECT_LT(plain.test.psnr, 45);
  EXPECT_GT(aligned.whole.psnr, 60);  // nearly all 8-bit values are equal
  EXPECT_GT(aligned.whole.ssim, 0.9999);
  EXPECT_NEAR(aligned.degrees, 0.5, 0.2);  // small rotations and shifts look similar
  EXPECT_GT(aligned.pixels, 0.3);
  ASSERT_EQ(aligned.views.size(), 2u);
  EXPECT_EQ(aligned.views[0].name, "00");
  EXPECT_EQ(aligned.views[1].name, "08");
  EXPECT_EQ(aligned.right.views, 0);
}

// Fitted on the left half, measured on the right half.
TEST_F(AlignedEvaluationOfARing, MeasuresExposuresOnTheOtherHalf) {
  const AffineColor exposure{{0.85, 1.1, 0.95}, {0.03, -0.01, 0}};
  for (View& view : scene_.views) {
    exposure.Apply(HostSpan<float>{view.image.rgb.data(), static_cast<Index>(view.image.rgb.size())});
  }
  options_.free.color = true;
  const AlignedEvaluation aligned = EvaluateAligned(model_, scene_, options_);
  EXPECT_LT(aligned.right.psnr, 35);
  EXPECT_GT(aligned.right_exposed.psnr, 50);
  EXPECT_LT(aligned.whole.psnr, 35);  // cameras alone are not enough
  for (const AlignedView& view : aligned.views) {
    EXPECT_NEAR(view.exposure.gain[0], 0.85, 1e-3);
    EXPECT_NEAR(view.exposure.offset[1], -0.01, 1e-3);
  }
  // The right half does not affect the fit.
  for (View& view : scene_.views) {
    for (std::size_t row = 0; row < 3 * 72; ++row) {
      for (std::size_t x = 48; x < 96; ++x) view.image.rgb[row * 96 + x] *= 0.5f;
    }
  }
  const AlignedEvaluation halved = EvaluateAligned(model_, scene_, options_);
  EXPECT_NEAR(halved.views[0].exposure.gain[0], 0.85, 0.05);
  EXPECT_LT(halved.right_exposed.psnr, 30);
}

// A view with a masked left half is skipped. Without other views the result is NaN, not 0 dB.
TEST_F(AlignedEvaluationOfARing, MeasuresHalvesWhereThereAreTwo) {
  options_.free.color = true;
  const AlignedEvaluation both = EvaluateAligned(model_, scene_, options_);
  ASSERT_EQ(both.right.views, 2);
  const auto test_view = [&](std::size_t k) -> View& {
    return *std::ranges::find_if(scene_.views, [&](const View& view) { return view.name == both.views[k].name; });
  };
  const auto mask_left = [&](View& view) {
    view.image.mask.assign(view.image.num_pixels(), 1);
    for (std::size_t pixel = 0; pixel < view.image.num_pixels(); ++pixel) {
      if (pixel % 96 < 48) view.image.mask[pixel] = 0;
    }
  };
  mask_left(test_view(0));
  const AlignedEvaluation one = EvaluateAligned(model_, scene_, options_);
  EXPECT_EQ(one.whole.views, 2);
  EXPECT_EQ(one.right.views, 1);
  EXPECT_FALSE(one.views[0].has_halves);
  EXPECT_EQ(one.right.psnr, both.views[1].right.psnr);
  EXPECT_EQ(one.right_exposed.ssim, both.views[1].right_exposed.ssim);
  mask_left(test_view(1));
  const AlignedEvaluation none = EvaluateAligned(model_, scene_, options_);
  EXPECT_EQ(none.right.views, 0);
  EXPECT_TRUE(std::isnan(none.right_exposed.psnr));
  EXPECT_GT(none.whole.psnr, 30);
}

TEST_F(AlignedEvaluationOfARing, KeepsViewsThatCannotBeFittedAsTheyAre) {
  const Evaluation plain = Plain();
  for (View& view : scene_.views) {
    if (view.is_test()) std::fill(view.image.rgb.begin(), view.image.rgb.end(), 0.0f);
  }
  const Evaluation black = Plain();
  const AlignedEvaluation aligned = EvaluateAligned(model_, scene_, options_);
  EXPECT_EQ(aligned.not_found, 2);
  EXPECT_EQ(aligned.whole.psnr, black.test.psnr);
  EXPECT_EQ(aligned.whole.ssim, black.test.ssim);
  EXPECT_EQ(aligned.pixels, 0);
  EXPECT_NE(black.test.psnr, plain.test.psnr);
}

TEST(AlignedEvaluation, OfNoTestViewsIsEmpty) {
  const SplatModel model = test::RandomModel(20, 0, 12);
  Scene scene = test::RingOfCameras(3, 40, 30, false);
  test::RenderTruth(model, 0, &scene);
  const AlignedEvaluation aligned = EvaluateAligned(model, scene, {.near = 0.01});
  EXPECT_TRUE(aligned.views.empty());
  EXPECT_EQ(aligned.whole.views, 0);
  EXPECT_TRUE(std::isnan(aligned.degrees));
  EXPECT_TRUE(std::isnan(aligned.whole.psnr));
}

}  // namespace
}  // namespace vesta::gs
