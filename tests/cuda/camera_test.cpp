// SPDX-License-Identifier: Apache-2.0
// Derivatives of views by their cameras, and their curvature, on the GPU and on the host.
#include <utility>

#include "kernels/core/device_kernels.h"
#include "kernels/gaussian_splatting/device/device_splat_view.h"
#include "kernels/gaussian_splatting/view/camera_jacobian.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "splatting/cameras/derivatives/seen_view.h"
#include "splatting/cameras/derivatives/view_columns.inl"
#include "splatting/train/adam_stage/stage_views.h"
#include "tests/cuda/device_view.h"
#include "tests/cuda/on_device.h"
#include "tests/support/splat_scenes.h"

namespace vesta::test {
namespace {

// Relative to the norm, in float. Sums over all Gaussians have more cancellation.
constexpr double kProductTolerance = 1e-4, kSumTolerance = 1e-3;

class CudaCameras : public OnDevice {};

std::vector<Scene> Scenes() {
  std::vector<Scene> scenes;
  for (const SceneOptions& options : SceneKinds()) scenes.push_back(RandomScene(options, 8));
  scenes.push_back(WithBands(RandomScene(SceneOptions(), 8), {40, 29, 17, 5}));
  // More than one chunk of a sum.
  SceneOptions many;
  many.count = 5000, many.sigma_max = 1, many.sh_degree = 1;
  scenes.push_back(RandomScene(many, 9));
  return scenes;
}

template <class Tangent>
std::vector<double> Numbers(const Tangent& tangent) {
  return {std::begin(tangent.v), std::end(tangent.v)};
}

TEST_F(CudaCameras, ProductsWithPoseAndLensAreThoseOfTheHost) {
  for (const Scene& scene : Scenes()) {
    SCOPED_TRACE(scene.count);
    RenderedView<float> host(scene);
    DeviceRenderedView device(scene);
    DeviceBuffer<float> d_image(device.device_image.size());
    std::vector<float> expected(host.image.size());

    splat::PoseTangent xi;
    splat::LensTangent delta;
    Random random(9);
    for (double& value : xi.v) value = random.Normal();
    for (double& value : delta.v) value = random.Normal();
    ApplyPoseJ(device.view, device.model, xi, d_image.data(), device.workspace);
    ApplyPoseJ(host.view, host.model, xi, expected.data(), host.workspace);
    EXPECT_LT(RelativeError(ToHost(d_image), expected), kProductTolerance);
    ApplyLensJ(device.view, delta, d_image.data(), device.workspace);
    ApplyLensJ(host.view, delta, expected.data(), host.workspace);
    EXPECT_LT(RelativeError(ToHost(d_image), expected), kProductTolerance);

    const auto u = random.NormalVector<float>(host.image.size());
    device.ApplyJT(u);
    const splat::SplatTangent<float>*on_device = device.workspace.splat_sums.data(),
          *on_host = host.view.ApplyRasterJT(host.image.data(), u.data(), host.workspace);
    EXPECT_LT(RelativeError(Numbers(PoseCotangent(device.view, device.model, on_device)),
                            Numbers(PoseCotangent(host.view, host.model, on_host))),
              kSumTolerance);
    EXPECT_LT(RelativeError(Numbers(LensCotangent(device.view, on_device)), Numbers(LensCotangent(host.view, on_host))),
              kSumTolerance);
  }
}

// For the camera step of a masked view, with the number of device synchronisations.
template <class B>
struct GradientAndCurvature {
  std::vector<double> gradient, curvature;
  std::int64_t gradient_waits, curvature_waits;

  GradientAndCurvature(const splat::Model<float>& model, const Scene& scene,
                       const gs::TargetView<CpuBackend<float>>& target, const gs::FreeUnknowns& free) {
    const std::vector<gs::TargetView<B>> targets = gs::TargetsIn<B>({target});
    const gs::TargetView<B>& there = targets.front();
    gs::ViewPasses<B> passes;
    typename B::Vector g(static_cast<Index>(scene.x.size()));
    passes.AddGradient(model, there, scene.background, g.data());
    std::int64_t& waits = device::CountedHostWork().waits;
    waits = 0;
    gradient = GradientOf(gs::ProcessedView<B>{0, model, there, passes.view, passes.workspace.splat_sums.data(),
                                               passes.image, passes.image_gradient},
                          free);
    gradient_waits = std::exchange(waits, 0);
    curvature = ViewCurvature(free, {scene.background[0], scene.background[1], scene.background[2]}, model, there);
    curvature_waits = waits;
  }
};

TEST_F(CudaCameras, GradientAndCurvatureOfAViewAreThoseOfTheHost) {
  const Scene scene = RandomScene(SceneOptions(), 8);
  const RenderedView<float> host(scene);
  Random random(3);
  std::vector<float> truth;
  std::vector<std::uint8_t> mask;
  for (const float value : host.image) {
    truth.push_back(static_cast<float>(std::clamp(static_cast<double>(value) + 0.1 * random.Normal(), 0.0, 1.0)));
  }
  for (std::size_t i = 0; i < truth.size() / 3; ++i) mask.push_back(i % 5 == 0 ? 0 : 1);
  const gs::TargetView<CpuBackend<float>> target{scene.view, ViewOf(truth), ViewOf(mask)};
  const DeviceBuffer<float> x = ToDevice(host.x);
  const splat::Model<float> model = {x.data(), scene.layout(), scene.active_sh_degree};
  for (const gs::FreeUnknowns free : {gs::FreeUnknowns(), gs::FreeUnknowns{true, true, true}}) {
    SCOPED_TRACE(free.num_tangent());
    const GradientAndCurvature<CudaBackend<float>> found(model, scene, target, free);
    const GradientAndCurvature<CpuBackend<float>> expected(host.model, scene, target, free);
    ASSERT_EQ(found.gradient.size(), static_cast<std::size_t>(free.num_tangent()));
    EXPECT_LT(RelativeError(found.gradient, expected.gradient), kSumTolerance);
    EXPECT_LT(RelativeError(found.curvature, expected.curvature), kSumTolerance);
    // As in docs/cuda.md: one wait for all products of a view's images, two for building the view.
    EXPECT_EQ(found.gradient_waits, 1 + (free.color ? 1 : 0) + (free.lens ? 1 : 0));
    EXPECT_EQ(found.curvature_waits, 1 + 2);
  }
}

}  // namespace
}  // namespace vesta::test
