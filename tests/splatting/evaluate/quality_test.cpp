// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "splatting/evaluate/evaluation.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs {
namespace {

constexpr int kWidth = 24, kHeight = 18;
constexpr double kGrey = 102.0 / 255;  // the background, which alone is visible

// Views of the background only; the last `tests` are test views.
Scene FlatScene(const std::vector<double>& truths, int tests) {
  Scene scene = test::RingOfCameras(static_cast<int>(truths.size()), kWidth, kHeight, false);
  for (std::size_t v = 0; v < truths.size(); ++v) {
    scene.views[v].image = Image(kWidth, kHeight);
    for (float& value : scene.views[v].image.rgb) value = static_cast<float>(truths[v]);
    scene.views[v].role = v + static_cast<std::size_t>(tests) >= truths.size() ? ViewRole::kTest : ViewRole::kTraining;
  }
  return scene;
}

SplatModel NothingToSee() {
  SplatModel model = test::RandomModel(1, 0, 1);
  model.attribute(splat::kOpacity)[0] = -20;
  return model;
}

Evaluation Evaluate(const SplatModel& model, const Scene& scene) {
  Renderer renderer({kGrey, kGrey, kGrey}, NearPlane(scene));
  return renderer.Evaluate(model, scene);
}

// SSIM of flat images a and b. With g, the part of the 11 x 11 window (sigma 1.5) inside the image: means g a and g b,
// variances (g - g^2) a^2 and (g - g^2) b^2, covariance (g - g^2) a b.
double FlatSsim(double a, double b) {
  double weights[11], total = 0;
  for (int k = 0; k < 11; ++k) total += weights[k] = std::exp(-(k - 5) * (k - 5) / 4.5);
  const auto inside = [&](int at, int size) {
    double sum = 0;
    for (int k = 0; k < 11; ++k) {
      if (at + k - 5 >= 0 && at + k - 5 < size) sum += weights[k] / total;
    }
    return sum;
  };
  double sum = 0;
  for (int i = 0; i < kHeight; ++i) {
    for (int j = 0; j < kWidth; ++j) {
      const double g = inside(i, kHeight) * inside(j, kWidth), spread = g - g * g;
      sum += (2 * g * g * a * b + 1e-4) * (2 * spread * a * b + 9e-4) /
             ((g * g * (a * a + b * b) + 1e-4) * (spread * (a * a + b * b) + 9e-4));
    }
  }
  return sum / (kWidth * kHeight);
}

TEST(Evaluate, FlatImagesHaveKnownQuality) {
  const double truth = 51.0 / 255;
  const Evaluation e = Evaluate(NothingToSee(), FlatScene({truth, truth}, 1));
  const double psnr = -20 * std::log10(kGrey - truth), ssim = FlatSsim(kGrey, truth);
  for (const Quality& quality : {e.train, e.test}) {
    EXPECT_NEAR(quality.psnr, psnr, 1e-5);
    // tolerance for D2 of a flat window in float: photometric_formula.h
    EXPECT_NEAR(quality.ssim, ssim, 3e-6);
    EXPECT_EQ(quality.views, 1);
  }
  EXPECT_NEAR(e.cost, 0.8 * (kGrey - truth) + 0.2 * (1 - ssim), 1e-6);
}

TEST(Evaluate, MeansAreOverViews) {
  const double near = 92.0 / 255, far = 2.0 / 255, other = 52.0 / 255;
  const Evaluation e = Evaluate(NothingToSee(), FlatScene({near, far, other}, 1));
  EXPECT_EQ(e.train.views, 2);
  EXPECT_EQ(e.test.views, 1);
  EXPECT_NEAR(e.train.psnr, -10 * (std::log10(kGrey - near) + std::log10(kGrey - far)), 1e-5);
  EXPECT_NEAR(e.train.ssim, 0.5 * (FlatSsim(kGrey, near) + FlatSsim(kGrey, far)), 1e-6);
  EXPECT_NEAR(e.test.psnr, -20 * std::log10(kGrey - other), 1e-5);
}

// Of seven training views, the last of each run is measured (2, 4 and 6). Test views (the last) always are.
TEST(Evaluate, LooksAtSomeTrainingViewsEvenlySpread) {
  std::vector<double> truths(8, 2.0 / 255);
  for (const std::size_t measured : {2, 4, 6}) truths[measured] = 92.0 / 255;
  const Scene scene = FlatScene(truths, 1);
  Renderer renderer({kGrey, kGrey, kGrey}, NearPlane(scene));
  const Evaluation e = renderer.Evaluate(ToKernelModel(NothingToSee()), scene, {.most_trained = 3});
  EXPECT_EQ(e.train.views, 3);
  EXPECT_EQ(e.test.views, 1);
  EXPECT_NEAR(e.train.psnr, -20 * std::log10(kGrey - truths[2]), 1e-5);
  EXPECT_NEAR(e.test.psnr, -20 * std::log10(kGrey - truths[7]), 1e-5);
  EXPECT_NEAR(e.cost, 0.8 * (kGrey - truths[2]) + 0.2 * (1 - FlatSsim(kGrey, truths[2])), 1e-6);
}

TEST(MeasuredViews, AreAllWhereThereAreNoMore) {
  const Scene scene = FlatScene({0, 0, 0, 0}, 1);
  EXPECT_EQ(AreMeasured({.most_trained = 3}, scene.views), std::vector<bool>(4, true));
  EXPECT_EQ(AreMeasured({}, scene.views), std::vector<bool>(4, true));
  EXPECT_EQ(AreMeasured({.most_trained = 1}, scene.views), (std::vector<bool>{false, false, true, true}));
}

// Masked pixels do not count; for flat images the result is nearly exact.
TEST(Evaluate, QualityIsThatOfThePixelsThatCount) {
  const double truth = 51.0 / 255;
  Scene scene = FlatScene({truth, truth}, 1);
  const Evaluation whole = Evaluate(NothingToSee(), scene);
  for (View& view : scene.views) {
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const bool counts = i % kWidth < 8;
      view.image.mask.push_back(counts ? 1 : 0);
      // Masked: any colours.
      for (int c = 0; c < 3 && !counts; ++c) view.image.plane(c)[i] = static_cast<float>(i % 7) / 7;
    }
  }
  const Evaluation e = Evaluate(NothingToSee(), scene);
  for (const auto& [quality, all] : {std::pair{e.train, whole.train}, std::pair{e.test, whole.test}}) {
    EXPECT_NEAR(quality.psnr, all.psnr, 1e-5);
    EXPECT_LT(quality.ssim, 1);
    EXPECT_NEAR(quality.ssim, all.ssim, 0.15);
  }
  // Up to 8-bit rounding in windows across the mask border.
  EXPECT_NEAR(e.cost, 0.8 * (kGrey - truth) + 0.2 * (1 - e.train.ssim), 1e-4);
}

// PSNR and SSIM use 8-bit images, the cost float images.
TEST(Evaluate, QualityIsQuantisedAndTheCostIsNot) {
  const double truth = kGrey + 0.4 / 255;
  const Evaluation e = Evaluate(NothingToSee(), FlatScene({truth}, 0));
  EXPECT_TRUE(std::isinf(e.train.psnr));
  EXPECT_EQ(e.train.ssim, 1);
  EXPECT_NEAR(e.cost, 0.8 * (truth - kGrey) + 0.2 * (1 - FlatSsim(kGrey, truth)), 1e-7);
  EXPECT_EQ(e.test.views, 0);
  EXPECT_TRUE(std::isnan(e.test.psnr) && std::isnan(e.test.ssim)) << "nothing was measured";
}

TEST(Evaluate, RenderedTruthIsPerfect) {
  Scene scene = test::RingOfCameras(9, 40, 30, true);
  const SplatModel model = test::RandomModel(20, 2, 2);
  test::RenderTruth(model, 0, &scene);
  Renderer renderer({0, 0, 0}, NearPlane(scene));
  const Evaluation e = renderer.Evaluate(model, scene);
  EXPECT_EQ(e.train.views, 7);
  EXPECT_EQ(e.test.views, 2);
  EXPECT_TRUE(std::isinf(e.train.psnr) && std::isinf(e.test.psnr));
  EXPECT_EQ(e.train.ssim, 1);
  EXPECT_NEAR(e.cost, 0, 1e-7);
}

TEST(Evaluate, AViewHeldOutCountsForItselfOnly) {
  Scene scene = test::RingOfCameras(9, 40, 30, true);
  const SplatModel model = test::RandomModel(20, 1, 2);
  test::RenderTruth(test::RandomModel(20, 1, 3), 0, &scene);
  scene.views[3].role = ViewRole::kHeldOut;
  Renderer renderer({0, 0, 0}, NearPlane(scene));
  const Evaluation before = renderer.Evaluate(model, scene);
  EXPECT_EQ(before.train.views, 6);
  EXPECT_EQ(before.held_out.views, 1);
  EXPECT_EQ(before.test.views, 2);
  for (float& value : scene.views[3].image.rgb) value = 1 - value;
  const Evaluation changed = renderer.Evaluate(model, scene);
  EXPECT_NE(changed.held_out.psnr, before.held_out.psnr);
  EXPECT_EQ(changed.train.psnr, before.train.psnr);
  EXPECT_EQ(changed.test.psnr, before.test.psnr);
  EXPECT_EQ(changed.cost, before.cost);
}

TEST(Evaluate, ATestImageCountsForTheTestViewsOnly) {
  Scene scene = test::RingOfCameras(9, 40, 30, true);
  const SplatModel model = test::RandomModel(20, 1, 2);
  test::RenderTruth(test::RandomModel(20, 1, 3), 0, &scene);
  Renderer renderer({0, 0, 0}, NearPlane(scene));
  const Evaluation before = renderer.Evaluate(model, scene);
  ASSERT_TRUE(scene.views[8].is_test());
  ASSERT_FALSE(scene.views[3].is_test());
  Scene other_test = scene, other_train = scene;
  for (float& value : other_test.views[8].image.rgb) value = 1 - value;
  for (float& value : other_train.views[3].image.rgb) value = 1 - value;

  const Evaluation test_changed = renderer.Evaluate(model, other_test);
  EXPECT_EQ(test_changed.train.psnr, before.train.psnr);
  EXPECT_EQ(test_changed.train.ssim, before.train.ssim);
  EXPECT_EQ(test_changed.cost, before.cost);
  EXPECT_NE(test_changed.test.psnr, before.test.psnr);

  const Evaluation train_changed = renderer.Evaluate(model, other_train);
  EXPECT_EQ(train_changed.test.psnr, before.test.psnr);
  EXPECT_EQ(train_changed.test.ssim, before.test.ssim);
  EXPECT_NE(train_changed.train.psnr, before.train.psnr);
  EXPECT_GT(train_changed.cost, before.cost);
}

TEST(Evaluate, TakesViewsOfDifferentSizes) {
  const SplatModel model = test::RandomModel(20, 1, 4);
  Scene scene = test::RingOfCameras(2, 40, 30, false);
  scene.views[1].camera = ResizeCamera(scene.views[1].camera, 20, 15);
  Renderer renderer({0.5, 0.5, 0.5}, NearPlane(scene));
  for (View& view : scene.views) view.image = renderer.Render(model, view);
  EXPECT_EQ(scene.views[1].image.width, 20);
  EXPECT_EQ(scene.views[1].image.height, 15);
  EXPECT_TRUE(std::isinf(renderer.Evaluate(model, scene).train.psnr));
}

TEST(Pinhole, IsTheViewsCamera) {
  const Scene scene = test::RingOfCameras(5, 40, 30, false);
  const View& view = scene.views[2];
  const splat::PosedCamera camera = ToPosedCamera(view, 0.25);
  EXPECT_EQ(camera.width, 40);
  EXPECT_EQ(camera.height, 30);
  EXPECT_EQ(camera.lens.cx, view.camera.lens.cx);
  EXPECT_EQ(camera.lens.fy, view.camera.lens.fy);
  EXPECT_EQ(camera.near, 0.25);
  for (int r = 0; r < 3; ++r) {
    // The centre maps to the origin.
    double t = camera.T[r];
    for (int k = 0; k < 3; ++k) t += camera.R[3 * r + k] * camera.centre[k];
    EXPECT_NEAR(t, 0, 1e-14);
  }
}

// The near plane is at 1 % of the extent.
TEST(Pinhole, NearPlaneFollowsTheExtent) {
  Scene scene = test::RingOfCameras(4, 40, 30, false);
  scene.extent = 50;
  EXPECT_DOUBLE_EQ(NearPlane(scene), 0.5);
}

}  // namespace
}  // namespace vesta::gs
