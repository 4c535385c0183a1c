// SPDX-License-Identifier: Apache-2.0
// The sums for density control (kPullP, kPullQ) agree with exact derivatives of the reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/kernels/gaussian_splatting/reference.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

using test::RenderedView;
using test::Scene;

// The cotangents of the splats, by rank, with the sums for density control.
template <class S>
std::vector<SplatTangent<S>> Cotangents(RenderedView<S>& rendered, const std::vector<S>& u) {
  const SplatTangent<S>* sums = rendered.view.ApplyRasterJT(rendered.image.data(), u.data(), rendered.workspace);
  return {sums, sums + rendered.num_splats()};
}

// Sums over the pixels of |d loss / d u| and of |d loss / d v - beta d loss / d u|, where (u, v) is the projected mean
// of Gaussian i and the loss is the product of the image with its cotangent. The first is 2 ln 2 r |g p| per pixel, the
// second 2 ln 2 s |g q| (splat_sums.h).
struct Pulls {
  std::array<double, 2> pull = {0, 0};
  double margin = HUGE_VAL;  // of the nearest decision of all pixels
};
Pulls PullsOf(const Scene& scene, int i, const std::vector<double>& cotangent) {
  using Jet = ceres::Jet<double, 2>;
  const std::vector<Jet> x(scene.x.begin(), scene.x.end());
  std::vector<reference::ScreenGaussian<Jet>> gaussians =
      reference::Project(x, scene.count, scene.active_sh_degree, scene.view);
  reference::ScreenGaussian<Jet>& moved = gaussians[static_cast<std::size_t>(i)];
  moved.u.v[0] = 1, moved.v.v[1] = 1;
  const double beta = moved.b.a / moved.a.a;
  const reference::Image<Jet> image = reference::Blend(gaussians, scene.view, scene.background);
  Pulls result;
  const std::size_t pixels = image.margin.size();
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    double by_u = 0, by_v = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      by_u += cotangent[c * pixels + pixel] * image.color[c * pixels + pixel].v[0];
      by_v += cotangent[c * pixels + pixel] * image.color[c * pixels + pixel].v[1];
    }
    result.pull[0] += std::abs(by_u), result.pull[1] += std::abs(by_v - beta * by_u);
    result.margin = std::min(result.margin, image.margin[pixel]);
  }
  return result;
}

class PullSums : public testing::TestWithParam<test::SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, PullSums, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

TEST_P(PullSums, AreThoseOfTheReference) {
  const Scene scene = test::RandomScene(GetParam(), 40);
  RenderedView<double> rendered(scene);
  const std::vector<double> u = test::Random(41).NormalVector<double>(rendered.image.size());
  const std::vector<SplatTangent<double>> cotangents = Cotangents(rendered, u);
  const std::vector<double> condition = reference::Render(scene).condition;
  int compared = 0;
  for (int i = 0; i < scene.count; ++i) {
    const std::int32_t rank = rendered.view.rank_of()[i];
    if (rank < 0) continue;
    const Splat<double>& splat = rendered.view.splats()[rank];
    const double* w = cotangents[static_cast<std::size_t>(rank)].w;
    const Pulls expected = PullsOf(scene, i, u);
    ASSERT_GT(expected.margin, 1e-12);
    const double tolerance = std::max(1e-9, 1e-13 * condition[static_cast<std::size_t>(i)]);
    ASSERT_NEAR(kTwoLn2 * splat.r * w[kPullP], expected.pull[0], tolerance * expected.pull[0]) << i;
    ASSERT_NEAR(kTwoLn2 * splat.s * w[kPullQ], expected.pull[1], tolerance * expected.pull[1]) << i;
    compared += expected.pull[0] > 0 ? 1 : 0;
  }
  EXPECT_GT(compared, 0);
}

// The triangle inequality. Pixels partly cancel in the sums with signs.
template <class S>
void ExpectNoSmallerThanSumsWithSigns(const Scene& scene) {
  RenderedView<S> rendered(scene);
  const std::vector<S> u = test::Random(43).NormalVector<S>(rendered.image.size());
  double pulls = 0, with_signs = 0;
  for (const SplatTangent<S>& sum : Cotangents(rendered, u)) {
    const S slack = 1 + 100 * std::numeric_limits<S>::epsilon();
    ASSERT_LE(std::abs(sum.w[kXi]), slack * sum.w[kPullP]);
    ASSERT_LE(std::abs(sum.w[kZeta]), slack * sum.w[kPullQ]);
    pulls += static_cast<double>(sum.w[kPullP] + sum.w[kPullQ]);
    with_signs += static_cast<double>(std::abs(sum.w[kXi]) + std::abs(sum.w[kZeta]));
  }
  if (rendered.view.num_pixels() > 1) {
    EXPECT_LT(with_signs, 0.9 * pulls);
  }
}

TEST_P(PullSums, AreNoSmallerThanSumsWithSigns) {
  const Scene scene = test::RandomScene(GetParam(), 42);
  ExpectNoSmallerThanSumsWithSigns<double>(scene);
  ExpectNoSmallerThanSumsWithSigns<float>(scene);
}

}  // namespace
}  // namespace vesta::splat
