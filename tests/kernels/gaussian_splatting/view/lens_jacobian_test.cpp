// SPDX-License-Identifier: Apache-2.0
// The derivative of the image by the lens agrees with differences, and its products are adjoint.
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/gaussian_splatting/view/camera_jacobian.h"
#include "tests/kernels/gaussian_splatting/image_derivative.h"
#include "tests/support/adjoint.h"
#include "tests/support/any_threads.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

using test::RenderedView;
using test::Scene;
using test::SceneOptions;

LensTangent Unit(int k) {
  LensTangent delta;
  delta.v[k] = 1;
  return delta;
}

// No Gaussians at the border of the lens, where the derivative differs by design.
Scene SceneWithin(SceneOptions options, std::uint64_t seed) {
  options.border = 0.1;
  return test::RandomScene(options, seed);
}

Lens Changed(const Lens& lens, const double delta[kLensTangent]) {
  return {lens.fx * std::exp(delta[0]), lens.fy * std::exp(delta[1]), lens.cx + lens.fx * delta[2],
          lens.cy + lens.fy * delta[3], lens.model};
}

class LensJacobian : public testing::TestWithParam<SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, LensJacobian, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

// Central differences, away from decisions.
TEST_P(LensJacobian, IsTheDerivativeOfTheImage) {
  const Scene scene = SceneWithin(GetParam(), 93);
  RenderedView<double> rendered(scene);
  for (int k = 0; k < kLensTangent; ++k) {
    SCOPED_TRACE(k);
    std::vector<double> d_image(rendered.image.size());
    ApplyLensJ(rendered.view, Unit(k), d_image.data(), rendered.workspace);
    const auto changed = [&](double step) {
      Scene other = scene;
      double delta[kLensTangent] = {};
      delta[k] = step;
      other.view.lens = Changed(scene.view.lens, delta);
      return other;
    };
    test::ExpectDerivativeOfImage(scene, changed, d_image);
  }
}

template <class S>
void CheckAdjointness(const Scene& scene, double tolerance) {
  RenderedView<S> rendered(scene);
  test::Random random(93);
  const std::vector<S> u = random.NormalVector<S>(rendered.image.size());
  const LensTangent lens_bar =
      LensCotangent(rendered.view, rendered.view.ApplyRasterJT(rendered.image.data(), u.data(), rendered.workspace));
  std::vector<S> jv(u.size());
  for (int k = 0; k < kLensTangent; ++k) {
    ApplyLensJ(rendered.view, Unit(k), jv.data(), rendered.workspace);
    EXPECT_LE(test::AdjointGap(u, jv, {static_cast<S>(lens_bar.v[k])}, {S(1)}), tolerance) << k;
  }
}

TEST_P(LensJacobian, ProductsAreAdjoint) {
  const Scene scene = SceneWithin(GetParam(), 94);
  CheckAdjointness<double>(scene, GetParam().extreme ? 1e-6 : 1e-12);
  if (!GetParam().extreme) CheckAdjointness<float>(scene, 1e-4);
}

TEST(LensJacobianThreads, BitIdenticalForAnyNumber) {
  SceneOptions options;
  options.width = 90, options.height = 70, options.count = 4000, options.sh_degree = 1;
  options.sigma_min = 0.5, options.sigma_max = 4;
  RenderedView<float> rendered(test::RandomScene(options, 95));
  test::Random random(96);
  const std::vector<float> u = random.NormalVector<float>(rendered.image.size());
  test::ExpectSameForAnyThreads([&] {
    std::vector<float> d_image(u.size());
    ApplyLensJ(rendered.view, Unit(0), d_image.data(), rendered.workspace);
    const LensTangent sums =
        LensCotangent(rendered.view, rendered.view.ApplyRasterJT(rendered.image.data(), u.data(), rendered.workspace));
    return std::pair(d_image, std::vector<double>(sums.v, sums.v + kLensTangent));
  });
}

}  // namespace
}  // namespace vesta::splat
