// SPDX-License-Identifier: Apache-2.0
// Image and derivatives where a decision changes along a step: alpha floor, alpha cap, early stop, and the tiles of a
// splat.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/kernels/gaussian_splatting/extreme_checks.h"

namespace vesta::splat {
namespace {

using test::RenderedView;
using test::Scene;

double Logit(double p) { return std::log(p / (1 - p)); }

// Each layer is constant over the image, with these opacities, front to back, white before black.
Scene Layers(const std::vector<double>& opacities) {
  Scene scene = test::EmptyScene(test::AxisView(4, 4, 4), static_cast<int>(opacities.size()), 0);
  for (int i = 0; i < scene.count; ++i) {
    scene.At(kMean + 2, i) = 1 + 0.1 * i;
    scene.At(kQuaternion, i) = 1;
    for (int k = 0; k < 3; ++k)
      scene.At(kLogScale + k, i) = std::log(1e7), scene.At(kSh + k, i) = 0.5 / 0.28209479177387814;
    scene.At(kOpacity, i) = Logit(opacities[static_cast<std::size_t>(i)]);
  }
  for (double& color : scene.background) color = 0;
  return scene;
}

struct Threshold {
  const char* name;
  std::vector<double> before, after;  // opacities just below and above the threshold
  double jump;                        // of the image, with white Gaussians
};
void PrintTo(const Threshold& threshold, std::ostream* os) { *os << threshold.name; }

std::vector<Threshold> Thresholds() {
  return {
      {"Floor", {kAlphaFloor * (1 - 1e-6)}, {kAlphaFloor * (1 + 1e-6)}, kAlphaFloor},
      {"FloorBehindAnother", {0.5, kAlphaFloor * (1 - 1e-6)}, {0.5, kAlphaFloor * (1 + 1e-6)}, kAlphaFloor / 2},
      {"Cap", {kAlphaCap - 1e-6}, {kAlphaCap + 1e-6}, 0},
      // The fourth layer just closes the pixel and is then skipped.
      {"Stop", {0.9, 0.9, 0.9, 0.9 - 1e-5}, {0.9, 0.9, 0.9, 0.9 + 1e-5}, 9e-4},
  };
}

class Decision : public testing::TestWithParam<Threshold> {};
INSTANTIATE_TEST_SUITE_P(At, Decision, testing::ValuesIn(Thresholds()),
                         [](const auto& param) { return std::string(param.param.name); });

// The image jumps by at most the splat's weight. On each side, products are adjoint and J is the derivative there.
template <class S>
void CheckDecision(const Threshold& threshold) {
  constexpr bool kDouble = sizeof(S) == 8;
  const Scene scenes[] = {Layers(threshold.before), Layers(threshold.after)};
  RenderedView<S> before(scenes[0]), after(scenes[1]);
  for (std::size_t i = 0; i < before.image.size(); ++i) {
    EXPECT_NEAR(std::abs(static_cast<double>(after.image[i]) - before.image[i]), threshold.jump, 1e-5);
  }
  test::Random random(70);
  for (int side = 0; side < 2; ++side) {
    RenderedView<S>& rendered = side == 0 ? before : after;
    std::vector<double> v = random.NormalVector<double>(scenes[0].x.size());
    for (double& value : v) value = static_cast<float>(value);
    const std::vector<S> v_in(v.begin(), v.end()), u = random.NormalVector<S>(rendered.image.size());
    const test::ExpectedImage expected(scenes[side], v);
    const std::vector<S> Jv = rendered.ApplyJ(v_in);
    EXPECT_LE(test::AdjointGap(u, Jv, rendered.ApplyJT(u), v_in), kDouble ? 1e-11 : 1e-4);
    for (std::size_t i = 0; i < Jv.size(); ++i) {
      EXPECT_NEAR(Jv[i], expected.image.color[i].v[0], (kDouble ? 1e-12 : 1e-5) * (1 + expected.steepest));
    }
  }
}

TEST_P(Decision, JumpsByItsShareInDouble) { CheckDecision<double>(GetParam()); }
TEST_P(Decision, JumpsByItsShareInFloat) { CheckDecision<float>(GetParam()); }

// A splat moves across the corner of four tiles. At each step the image equals the reference, which has no tiles, and a
// step of a thousandth of a pixel changes it only a little. Decisions are close only at the rim, where alpha reaches
// the floor.
TEST(Decisions, TilesOfASplatChangeNothing) {
  Scene scene = test::EmptyScene(test::AxisView(40, 40, 40), 1, 0);
  scene.At(kMean + 2, 0) = 1;
  scene.At(kQuaternion, 0) = 1, scene.At(kQuaternion + 3, 0) = 0.4;
  const double sigma[3] = {0.05, 0.02, 0.03};
  for (int k = 0; k < 3; ++k) scene.At(kLogScale + k, 0) = std::log(sigma[k]), scene.At(kSh + k, 0) = 1;
  std::vector<double> last;
  std::vector<Index> pairs;
  for (int step = 0; step < 1000; ++step) {
    const double place = (8 + 0.012 * step - 20) / 40;  // pixels 8 to 20, on the diagonal
    scene.At(kMean, 0) = scene.At(kMean + 1, 0) = place;
    const RenderedView<double> rendered(scene);
    pairs.push_back(rendered.view.num_pairs());
    const reference::Image<double> expected = reference::Render(scene.x, 1, 0, scene.view, scene.background);
    for (std::size_t i = 0; i < rendered.image.size(); ++i) {
      ASSERT_NEAR(rendered.image[i], expected.color[i], 1e-12) << "step " << step;
      // The steepest slope of exp(-x^2 / 2 sigma^2) with colour differences below 1, plus the floor.
      if (!last.empty()) {
        ASSERT_LE(std::abs(rendered.image[i] - last[i]), 0.012 * 1.42 / 1.1 + kAlphaFloor);
      }
    }
    last = rendered.image;
  }
  EXPECT_EQ(*std::ranges::min_element(pairs), 1);
  EXPECT_EQ(*std::ranges::max_element(pairs), 4);
}

// The smallest possible weight, 1/255 of a transmittance just above 1e-4, with saturated colours.
TEST(Decisions, CachedEntriesOf16BitsKeepTheSmallestContribution) {
  std::vector<double> opacities(13, 0.5);  // leaves a transmittance of 1.22e-4
  opacities.push_back(1.0001 * kAlphaFloor);
  RenderedView<float> rendered(Layers(opacities));
  std::vector<float> v(rendered.x.size());
  v.back() = 1;  // the blue of the last splat
  const std::vector<float> expected = rendered.ApplyJ(v);
  ASSERT_NEAR(expected.back(), 0x1p-13 * kAlphaFloor * 0.28209479177387814, 1e-9);
  rendered.view.CacheJacobian(rendered.image.data(), CacheFormat::kHalf, rendered.workspace);
  EXPECT_NEAR(rendered.ApplyJ(v).back() / expected.back(), 1, 0x1p-10);
}

TEST(Decisions, CachedEntriesOf16BitsSaturateAtContrastsOf255) {
  for (const double harmonic : {1e3, 1e4, 1e6, -1e4}) {
    SCOPED_TRACE(harmonic);
    Scene scene = Layers({0.3, 0.4, 0.2});
    for (int k = 0; k < 3; ++k) scene.At(kSh + k, 1) = harmonic;
    RenderedView<float> rendered(scene);
    rendered.view.CacheJacobian(rendered.image.data(), CacheFormat::kHalf, rendered.workspace);
    test::Random random(71);
    const auto v = random.NormalVector<float>(rendered.x.size()), u = random.NormalVector<float>(rendered.image.size());
    const std::vector<float> Jv = rendered.ApplyJ(v), JTu = rendered.ApplyJT(u);
    ASSERT_TRUE(test::AllFinite(Jv));
    ASSERT_TRUE(test::AllFinite(JTu));
    EXPECT_LE(test::AdjointGap(u, Jv, JTu, v), 1e-5);
    // The derivative by a logit is alpha (1 - alpha) times the contrast.
    std::vector<float> by_opacity(v.size());
    by_opacity[static_cast<std::size_t>(Index{kOpacity} * scene.count + 1)] = 1;
    for (const float value : rendered.ApplyJ(by_opacity)) EXPECT_LE(std::abs(value), 0.7 * 0.24 * 256);
  }
}

}  // namespace
}  // namespace vesta::splat
