// SPDX-License-Identifier: Apache-2.0
// The image as a function of the lens: its derivative against Jets, differences and itself.
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/gaussian_splatting/formulas/project.h"
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
using Jet = ceres::Jet<double, kLensTangent>;

LensTangent Unit(int k) {
  LensTangent delta;
  delta.v[k] = 1;
  return delta;
}

// None whose projection is taken at the border of what the lens shows: there the derivative is another by design.
Scene SceneWithin(SceneOptions options, std::uint64_t seed) {
  options.border = 0.1;
  return test::RandomScene(options, seed);
}

Lens Changed(const Lens& lens, const double delta[kLensTangent]) {
  return {lens.fx * std::exp(delta[0]), lens.fy * std::exp(delta[1]), lens.cx + lens.fx * delta[2],
          lens.cy + lens.fy * delta[3], lens.model};
}

TEST(LensOfASplat, TangentAgreesWithJetsOfTheProjection) {
  const Scene scene = SceneWithin({}, 91);
  RenderedView<double> rendered(scene);
  std::vector<double> d_image(rendered.image.size());
  std::vector<SplatTangent<double>> tangents[kLensTangent];
  for (int k = 0; k < kLensTangent; ++k) {
    ApplyLensJ(rendered.view, Unit(k), d_image.data(), rendered.workspace);
    const auto& of_splats = rendered.workspace.splat_sums;  // where it leaves them
    tangents[k].assign(of_splats.begin(), of_splats.begin() + rendered.num_splats());
  }
  CameraConstants<Jet, Pinhole<Jet>> camera = ConstantsOf<Pinhole<Jet>>(scene.view);
  const Lens& lens = scene.view.lens;
  camera.lens.fx = lens.fx * exp(Jet(0, 0)), camera.lens.fy = lens.fy * exp(Jet(0, 1));
  camera.lens.cx = lens.cx + lens.fx * Jet(0, 2), camera.lens.cy = lens.cy + lens.fy * Jet(0, 3);
  int compared = 0;
  for (int i = 0; i < scene.count; ++i) {
    const std::int32_t rank = rendered.view.rank_of()[i];
    if (rank < 0) continue;
    Jet mean[3], log_scale[3], quaternion[4];
    for (int k = 0; k < 3; ++k) mean[k] = Jet(scene.At(kMean + k, i)), log_scale[k] = Jet(scene.At(kLogScale + k, i));
    for (int k = 0; k < 4; ++k) quaternion[k] = Jet(scene.At(kQuaternion + k, i));
    ProjectionState<Pinhole<Jet>, Jet> state;
    const SplatShape<Jet> jet = Project(camera, mean, log_scale, quaternion, state);
    const SplatShape<double> shape = {jet.u.a, jet.v.a, jet.r.a, jet.s.a, jet.beta.a};
    ++compared;
    for (int k = 0; k < kLensTangent; ++k) {
      double w[kLambda];
      WhitenTangent(shape, {jet.u.v[k], jet.v.v[k], jet.r.v[k], jet.s.v[k], jet.beta.v[k]}, w);
      const SplatTangent<double>& found = tangents[k][static_cast<std::size_t>(rank)];
      for (int row = 0; row < kLambda; ++row) {
        EXPECT_NEAR(found.w[row], w[row], 1e-9 * (1 + std::abs(w[row]))) << "Gaussian " << i << ", row " << row << k;
      }
      for (int row = kLambda; row < kSplatTangent; ++row) EXPECT_EQ(found.w[row], 0);
    }
  }
  EXPECT_GT(compared, 10);
}

class LensJacobian : public testing::TestWithParam<SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, LensJacobian, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

// By central differences of images rendered through changed lenses, where no decision is near.
TEST_P(LensJacobian, IsTheDerivativeOfTheImage) {
  const Scene scene = SceneWithin(GetParam(), 92);
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
