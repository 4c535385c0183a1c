// SPDX-License-Identifier: Apache-2.0
// Extreme Gaussians and cameras in both precisions (on a device: tests/cuda/extreme_scenes_test.cpp).
#include <gtest/gtest.h>

#include "tests/kernels/gaussian_splatting/extreme_checks.h"

namespace vesta::splat {
namespace {

using test::ExtremeScene;
using test::RenderedView;

class Extremes : public testing::TestWithParam<ExtremeScene> {};
INSTANTIATE_TEST_SUITE_P(Gaussians, Extremes, testing::ValuesIn(test::ExtremeGaussians()),
                         [](const auto& param) { return param.param.name; });
INSTANTIATE_TEST_SUITE_P(Cameras, Extremes, testing::ValuesIn(test::ExtremeCameras()),
                         [](const auto& param) { return param.param.name; });

TEST_P(Extremes, InDouble) { test::CheckExtremeScene<RenderedView<double>>(GetParam()); }
TEST_P(Extremes, InFloat) { test::CheckExtremeScene<RenderedView<float>>(GetParam()); }

// Thousands of splats are blended, and rounding does not decide where the pixel closes.
TEST(ExtremeScenes, TenThousandSplatsCoverOnePixel) {
  const std::vector<ExtremeScene> cases = test::ExtremeGaussians();
  const test::Scene& scene = std::ranges::find(cases, "TenThousandOnOnePixel", &ExtremeScene::name)->scene;
  const reference::Image<double> image = reference::Render(scene.x, scene.count, 3, scene.view, scene.background);
  const auto most = std::ranges::max_element(image.blended);
  EXPECT_GT(*most, 1500);
  EXPECT_GT(image.margin[static_cast<std::size_t>(most - image.blended.begin())], 1e-3);
}

// One parameter of a Gaussian is swept from far below to far beyond the range of float.
struct Sweep {
  const char* name;
  double from, to, step;
  void (*set)(test::Scene& scene, double at);
};
void PrintTo(const Sweep& sweep, std::ostream* os) { *os << sweep.name; }

void SetLogScales(test::Scene& scene, int first, int last, double log_scale) {
  for (int axis = first; axis <= last; ++axis) scene.At(kLogScale + axis, 0) = log_scale;
}
constexpr Sweep kSweeps[] = {
    {"SizesOfBalls", -90, 90, 0.25, [](test::Scene& scene, double at) { SetLogScales(scene, 0, 2, at); }},
    {"SizesOfNeedles", -90, 90, 0.25, [](test::Scene& scene, double at) { SetLogScales(scene, 1, 1, at); }},
    {"SizesOfDiscs", -90, 90, 0.25, [](test::Scene& scene, double at) { SetLogScales(scene, 0, 1, at); }},
    {"Logits", -120, 120, 1, [](test::Scene& scene, double at) { scene.At(kOpacity, 0) = at; }},
    {"LengthsOfQuaternions", -30, 30, 0.1,
     [](test::Scene& scene, double at) {
       for (int k = 0; k < 4; ++k) scene.At(kQuaternion + k, 0) *= std::pow(10, at);
     }},
    {"Harmonics", -10, 37, 0.25,
     [](test::Scene& scene, double at) {
       for (int a = kSh; a < kMaxAttributes; ++a) scene.At(a, 0) *= std::pow(10, at);
     }},
    {"Depths", -2, 37, 0.25, [](test::Scene& scene, double at) { scene.At(kMean + 2, 0) = std::pow(10, at); }},
    {"DepthsOfGrowing", -2, 37, 0.25,
     [](test::Scene& scene, double at) {
       scene.At(kMean + 2, 0) = std::pow(10, at);
       SetLogScales(scene, 0, 2, at * std::log(10) - 1);
     }},
    {"FocalLengths", -37, 37, 0.25,
     [](test::Scene& scene, double at) { scene.view.lens.fx = scene.view.lens.fy = std::pow(10, at); }},
    {"Sideways", -10, 37, 0.25, [](test::Scene& scene, double at) { scene.At(kMean, 0) = std::pow(10, at); }},
};

class ExtremeSweep : public testing::TestWithParam<Sweep> {};
INSTANTIATE_TEST_SUITE_P(Of, ExtremeSweep, testing::ValuesIn(kSweeps),
                         [](const auto& param) { return std::string(param.param.name); });

// The image, its derivatives and their squares are finite.
template <class S>
void CheckSweep(const Sweep& sweep) {
  const std::vector<ExtremeScene> cases = test::ExtremeGaussians();
  const test::Scene& one = std::ranges::find(cases, "One", &ExtremeScene::name)->scene;
  test::Random random(31);
  const std::vector<S> v = random.NormalVector<S>(one.x.size());
  const std::vector<S> u =
      random.NormalVector<S>(static_cast<std::size_t>(Index{3} * one.view.width * one.view.height));
  std::vector<S> omega = u;
  for (S& value : omega) value *= value;
  Index seen = 0;
  for (double at = sweep.from; at <= sweep.to; at += sweep.step) {
    SCOPED_TRACE(at);
    test::Scene scene = one;
    sweep.set(scene, at);
    RenderedView<S> rendered(scene);
    seen += rendered.num_splats();
    EXPECT_TRUE(test::AllFinite(rendered.image));
    EXPECT_TRUE(test::AllFinite(rendered.ApplyJ(v)));
    EXPECT_TRUE(test::AllFinite(rendered.ApplyJT(u)));
    EXPECT_TRUE(test::AllFinite(rendered.Gram(omega)));
  }
  EXPECT_GT(seen, 5);
}

TEST_P(ExtremeSweep, IsFiniteInDouble) { CheckSweep<double>(GetParam()); }
TEST_P(ExtremeSweep, IsFiniteInFloat) { CheckSweep<float>(GetParam()); }

}  // namespace
}  // namespace vesta::splat
