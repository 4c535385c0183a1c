// SPDX-License-Identifier: Apache-2.0
// Rendered images agree with the slow reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "kernels/gaussian_splatting/formulas/project.h"
#include "tests/kernels/gaussian_splatting/extreme_checks.h"
#include "tests/kernels/gaussian_splatting/reference.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

using test::RenderedView;
using test::Scene;
using test::SceneOptions;

constexpr std::uint64_t kSeeds = 3;

class Rendering : public testing::TestWithParam<SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, Rendering, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

TEST_P(Rendering, DoubleIsTheReference) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Scene scene = test::RandomScene(GetParam(), seed);
    const reference::Image<double> expected = reference::Render(scene);
    const RenderedView<double> rendered(scene);
    const std::size_t pixels = expected.margin.size();
    for (std::size_t i = 0; i < rendered.image.size(); ++i) {
      if (expected.margin[i % pixels] < 1e-9) continue;
      ASSERT_NEAR(rendered.image[i], expected.color[i], 1e-9) << "seed " << seed << ", entry " << i;
    }
  }
}

// In float, decisions within rounding of their threshold may change. Such pixels are few, and their errors bounded: the
// floor drops a weight below 1/255, the stop one below 0.99 * 0.01.
TEST_P(Rendering, FloatAgreesButForDecisionsWithinRounding) {
  constexpr double kBand = 1e-3, kTolerance = 1e-4, kFlip = 0.012;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Scene scene = test::RandomScene(GetParam(), seed);
    const reference::Image<double> expected = reference::Render(scene);
    const RenderedView<float> rendered(scene);
    const std::size_t pixels = expected.margin.size();
    double brightest = 1;
    for (const Splat<float>& splat : rendered.view.splats()) {
      for (const float c : splat.color) brightest = std::max<double>(brightest, c);
    }
    int flips = 0;
    for (std::size_t i = 0; i < rendered.image.size(); ++i) {
      const double error = std::abs(rendered.image[i] - expected.color[i]);
      if (error <= kTolerance) continue;
      ASSERT_LT(expected.margin[i % pixels], kBand) << "seed " << seed << ", entry " << i << ", error " << error;
      ASSERT_LE(error, kFlip * brightest) << "seed " << seed << ", entry " << i;
      ++flips;
    }
    EXPECT_LE(flips, static_cast<int>(rendered.image.size() / 100));
  }
}

// The scenes match their names, so the tests of the operators are meaningful.
TEST_P(Rendering, CountsWhatIsVisited) {
  const Scene scene = test::RandomScene(GetParam(), 4);
  const reference::Image<double> expected = reference::Render(scene);
  const std::int64_t blended = std::accumulate(expected.blended.begin(), expected.blended.end(), std::int64_t{0});
  const VisitCounts exact = RenderedView<double>(scene).view.CountVisits();
  // In double a vector holds one pixel.
  EXPECT_EQ(exact.pixels, blended);
  EXPECT_EQ(exact.useful, blended);
  const RenderedView<float> rendered(scene);
  const VisitCounts counts = rendered.view.CountVisits();
  EXPECT_NEAR(static_cast<double>(counts.pixels), static_cast<double>(blended),
              0.01 * static_cast<double>(blended) + 5);
  EXPECT_LE(counts.useful, counts.vectors);
  EXPECT_LE(counts.useful, counts.pixels);
  EXPECT_LE(counts.pairs, rendered.view.num_pairs());
}

TEST(Scenes, ReachTheDecisionsTheyAreFor) {
  for (const SceneOptions& options : test::SceneKinds()) {
    const reference::Image<double> image = reference::Render(test::RandomScene(options, 0));
    if (options.name == "CappedAndClosed") {
      EXPECT_GT(image.capped, 10);
      EXPECT_GT(image.closed, 100);
    }
    if (options.name == "AllOpaque") {
      EXPECT_GT(image.capped, 50);
      EXPECT_GT(image.closed, 100);
    }
    if (options.name == "ManyLayers") {
      EXPECT_GT(image.closed, 100);
      EXPECT_GE(*std::max_element(image.blended.begin(), image.blended.end()), 50);
    }
    EXPECT_GT(*std::max_element(image.blended.begin(), image.blended.end()), 0) << options.name;
  }
}

TEST(Rendering, WithoutGaussiansIsTheBackground) {
  SceneOptions options;
  options.count = 0;
  const RenderedView<float> rendered(test::RandomScene(options, 0));
  const std::size_t pixels = rendered.image.size() / 3;
  for (std::size_t i = 0; i < rendered.image.size(); ++i) {
    EXPECT_EQ(rendered.image[i], static_cast<float>(Scene().background[i / pixels]));
  }
}

// At equal depths, the lower index is in front.
TEST(Rendering, EqualDepthsKeepTheOrderOfIndices) {
  SceneOptions options;
  options.sh_degree = 0, options.count = 12, options.sigma_min = 5, options.border = 0;
  Scene scene = test::RandomScene(options, 4);
  for (int i = 1; i < scene.count; ++i) {
    for (int k = 0; k < 3; ++k) scene.At(kMean + k, i) = scene.At(kMean + k, 0);
  }
  const reference::Image<double> expected = reference::Render(scene);
  const RenderedView<double> rendered(scene);
  for (std::size_t i = 0; i < rendered.image.size(); ++i) {
    ASSERT_NEAR(rendered.image[i], expected.color[i], 1e-9) << i;
  }
  for (int i = 0; i < scene.count; ++i) EXPECT_EQ(rendered.view.rank_of()[i], i);
}

// One Gaussian, and a camera at the origin that looks along z, with focal lengths of 30 pixels.
Scene OneGaussianOnTheAxis() {
  SceneOptions options;
  options.count = 1, options.sh_degree = 0, options.aspect_max = 1;
  Scene scene = test::RandomScene(options, 5);
  scene.view = {.R = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                .T = {},
                .centre = {},
                .lens = {.fx = 30, .fy = 30, .cx = 15, .cy = 10},
                .width = options.width,
                .height = options.height,
                .near = 0.1};
  return scene;
}

// A large Gaussian whose mean moves sideways out of the image at constant depth. It is visible up to the guard band but
// not beyond, although its linearised ellipse covers the image.
TEST(Rendering, MeansBeyondTheGuardBandAreInvisible) {
  Scene scene = OneGaussianOnTheAxis();
  // Flat along the axis: a deep Gaussian would be culled for another reason.
  for (int k = 0; k < 3; ++k) scene.At(kLogScale + k, 0) = std::log(k == 2 ? 0.01 : 20.0);
  for (int k = 0; k < 4; ++k) scene.At(kQuaternion + k, 0) = k == 0 ? 1 : 0;
  scene.At(kOpacity, 0) = 3;
  // At depth 1 the mean projects to this pixel.
  const auto seen_at = [&](int axis, double pixel) {
    const double centre[2] = {scene.view.lens.cx, scene.view.lens.cy};
    for (int k = 0; k < 2; ++k) scene.At(kMean + k, 0) = k == axis ? (pixel - centre[k]) / 30 : 0;
    scene.At(kMean + 2, 0) = 1;
    const RenderedView<double> rendered(scene);
    return rendered.view.rank_of()[0] >= 0;
  };
  const int size[2] = {scene.view.width, scene.view.height};
  for (const int axis : {0, 1}) {
    EXPECT_TRUE(seen_at(axis, -(kGuardBand - 0.01) * size[axis]));
    EXPECT_FALSE(seen_at(axis, -(kGuardBand + 0.01) * size[axis]));
    EXPECT_TRUE(seen_at(axis, (kGuardBand + 0.99) * size[axis]));
    EXPECT_FALSE(seen_at(axis, (kGuardBand + 1.01) * size[axis]));
  }
}

// A Gaussian that is deep relative to its distance is rendered inside the image and up to the clamp, but not farther
// out, on any side. A slightly shallower one is rendered there too.
TEST(Rendering, DeepGaussiansBesideTheImageAreInvisible) {
  Scene scene = OneGaussianOnTheAxis();
  scene.At(kOpacity, 0) = 3;
  // Rotated by 45 degrees about y, so that two axes share the depth.
  const double turn[4] = {std::cos(std::numbers::pi / 8), 0, std::sin(std::numbers::pi / 8), 0};
  for (int k = 0; k < 4; ++k) scene.At(kQuaternion + k, 0) = turn[k];
  constexpr double kDepth = 3;
  const auto seen_at = [&](int axis, double pixel, double spread) {
    for (int k = 0; k < 3; ++k) scene.At(kLogScale + k, 0) = std::log(k == 1 ? 2.0 : spread * kDepth);
    const double centre[2] = {scene.view.lens.cx, scene.view.lens.cy};
    for (int k = 0; k < 2; ++k) scene.At(kMean + k, 0) = k == axis ? (pixel - centre[k]) / 30 * kDepth : 0;
    scene.At(kMean + 2, 0) = kDepth;
    const RenderedView<double> rendered(scene);
    return rendered.view.rank_of()[0] >= 0;
  };
  const int size[2] = {scene.view.width, scene.view.height};
  for (const int axis : {0, 1}) {
    for (const bool is_far_side : {false, true}) {
      // Beyond the border, in image sizes.
      const auto pixel = [&](double beyond) { return (is_far_side ? 1 + beyond : -beyond) * size[axis]; };
      EXPECT_TRUE(seen_at(axis, pixel(0.14), 1.2));
      EXPECT_FALSE(seen_at(axis, pixel(0.16), 1.2));
      EXPECT_FALSE(seen_at(axis, pixel(0.16), 1.01 * kDepthSpread));
      EXPECT_TRUE(seen_at(axis, pixel(0.16), 0.99 * kDepthSpread));
    }
    EXPECT_TRUE(seen_at(axis, 0.5 * size[axis], 5));
  }
}

TEST(Rendering, LowerActiveDegreeIgnoresTheBandsAbove) {
  SceneOptions options;
  for (int active = 0; active <= 3; ++active) {
    Scene scene = test::RandomScene(options, 5);
    scene.active_sh_degree = active;
    const reference::Image<double> expected = reference::Render(scene);
    const RenderedView<double> rendered(scene);
    for (std::size_t i = 0; i < rendered.image.size(); ++i) {
      ASSERT_NEAR(rendered.image[i], expected.color[i], 1e-9) << active;
    }
  }
}

// A NaN parameter removes its Gaussian and affects nothing else; infinite and enormous ones keep everything finite, in
// both precisions, also products with J and its transpose.
template <class S>
void CheckPoison() {
  SceneOptions options;
  options.count = 19;
  options.sigma_min = 3;
  const Scene clean = test::RandomScene(options, 6);
  const int attributes = NumAttributes(options.sh_degree);
  constexpr int kVictim = 9;
  Scene without = clean;
  without.At(kOpacity, kVictim) = -100;
  const RenderedView<S> expected(without);
  test::Random random(8);
  for (int attribute = 0; attribute < attributes; ++attribute) {
    for (const double poison : {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, -HUGE_VAL, 1e30, -1e30, 1e-42}) {
      SCOPED_TRACE(testing::Message() << "attribute " << attribute << " = " << poison);
      Scene scene = clean;
      scene.At(attribute, kVictim) = poison;
      RenderedView<S> rendered(scene);
      if (std::isnan(poison)) {
        ASSERT_EQ(rendered.view.rank_of()[kVictim], -1);
        ASSERT_EQ(rendered.image, expected.image);
      }
      ASSERT_TRUE(test::AllFinite(rendered.image));
      ASSERT_TRUE(test::AllFinite(rendered.ApplyJ(random.NormalVector<S>(scene.x.size()))));
      ASSERT_TRUE(test::AllFinite(rendered.ApplyJT(random.NormalVector<S>(rendered.image.size()))));
    }
  }
}

TEST(Rendering, NonFiniteGaussiansAreInvisibleInFloat) { CheckPoison<float>(); }
TEST(Rendering, NonFiniteGaussiansAreInvisibleInDouble) { CheckPoison<double>(); }

}  // namespace
}  // namespace vesta::splat
