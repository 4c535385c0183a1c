// SPDX-License-Identifier: Apache-2.0
#include "tests/problems/gaussian_splatting/ring_scene.h"

#include <cmath>
#include <numbers>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/math/spherical_harmonics.h"
#include "splatting/evaluate/evaluation.h"
#include "tests/support/random.h"

namespace vesta::gs::test {
namespace {

using Vec3 = std::array<double, 3>;

Vec3 Cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vec3 Normalized(Vec3 a) {
  const double length = std::hypot(a[0], a[1], a[2]);
  for (double& value : a) value /= length;
  return a;
}

}  // namespace

SplatModel RandomModel(Index count, int sh_degree, std::uint64_t seed) {
  vesta::test::Random random(seed);
  SplatModel model;
  model.Resize(sh_degree, count);
  const auto set = [&](int attribute, Index i, double value) {
    model.attribute(attribute)[i] = static_cast<float>(value);
  };
  for (Index i = 0; i < count; ++i) {
    const Vec3 direction = Normalized({random.Normal(), random.Normal(), random.Normal()});
    const double radius = 0.7 * std::cbrt(random.Uniform(0, 1));
    for (int k = 0; k < 3; ++k) {
      set(splat::kMean + k, i, radius * direction[static_cast<std::size_t>(k)]);
      set(splat::kLogScale + k, i, std::log(random.LogUniform(0.05, 0.2)));
      set(splat::kSh + k, i, random.Uniform(-0.15, 0.4) / sh::k0);
    }
    for (int k = 0; k < 4; ++k) set(splat::kQuaternion + k, i, random.Normal());
    const double opacity = random.Uniform(0.3, 0.9);
    set(splat::kOpacity, i, std::log(opacity / (1 - opacity)));
    for (int a = splat::kSh + 3; a < model.num_attributes(); ++a) set(a, i, 0.03 * random.Normal());
  }
  return model;
}

std::vector<std::uint8_t> MixedDegrees(std::size_t count) {
  std::vector<std::uint8_t> degrees(count);
  for (std::size_t i = 0; i < count; ++i) degrees[i] = static_cast<std::uint8_t>(i % 4);
  return degrees;
}

SplatModel Perturbed(const SplatModel& model, double amount, std::uint64_t seed) {
  vesta::test::Random random(seed);
  SplatModel result = model;
  for (float& value : result.data) value += static_cast<float>(amount * random.Normal());
  return result;
}

Scene RingOfCameras(int views, int width, int height, bool with_test_views) {
  Scene scene;
  for (int v = 0; v < views; ++v) {
    const double angle = 2 * std::numbers::pi * v / views, tilt = 0.4 * std::sin(2.5 * v);
    const Vec3 centre = {3 * std::cos(angle) * std::cos(tilt), 3 * std::sin(tilt),
                         3 * std::sin(angle) * std::cos(tilt)};
    const Vec3 forward = Normalized({-centre[0], -centre[1], -centre[2]});
    const Vec3 right = Normalized(Cross({0, 1, 0}, forward)), down = Cross(forward, right);
    View view;
    view.name = std::string(v < 10 ? "0" : "") + std::to_string(v);
    view.camera = {width, height, {1.5 * width, 1.5 * width, 0.48 * width, 0.53 * height}};
    for (std::size_t k = 0; k < 3; ++k) {
      view.rotation[k] = right[k], view.rotation[3 + k] = down[k], view.rotation[6 + k] = forward[k];
      view.translation[0] -= right[k] * centre[k];
      view.translation[1] -= down[k] * centre[k];
      view.translation[2] -= forward[k] * centre[k];
    }
    scene.views.push_back(view);
  }
  if (with_test_views) SortAndSplit(&scene.views);
  scene.extent = SceneExtent(scene.views, scene.points);
  return scene;
}

void RenderTruth(const SplatModel& model, double noise, Scene* scene) {
  Renderer renderer({0, 0, 0}, NearPlane(*scene));
  for (View& view : scene->views) view.image = renderer.Render(model, view);
  vesta::test::Random random(99);
  scene->points = {};
  for (Index i = 0; i < model.count; ++i) {
    std::array<float, 3> position{}, color{};
    for (int k = 0; k < 3; ++k) {
      const auto c = static_cast<std::size_t>(k);
      position[c] = model.attribute(splat::kMean + k)[i] + static_cast<float>(noise * random.Normal());
      color[c] = 0.5f + static_cast<float>(sh::k0) * model.attribute(splat::kSh + k)[i];
    }
    scene->points.positions.push_back(position);
    scene->points.colors.push_back(color);
  }
}

namespace {

// A ring of cameras with images of one model.
Scene RingOf(const SplatModel& model, int views) {
  Scene scene = RingOfCameras(views, 40, 30, false);
  RenderTruth(model, 0, &scene);
  return scene;
}

}  // namespace

template <class S>
RingProblem<S>::RingProblem(int num_views, Index gaussians, int sh_degree, std::uint64_t seed)
    : RingProblem(RingOf(RandomModel(gaussians, sh_degree, seed), num_views),
                  RandomModel(gaussians, sh_degree, seed + 1)) {}

template <class S>
RingProblem<S>::RingProblem(const Scene& scene, const SplatModel& start) {
  x.Resize(static_cast<Index>(start.data.size()));
  std::copy(start.data.begin(), start.data.end(), x.begin());
  static_cast<splat::ModelLayout&>(options) = start;
  options.background = {0.2, 0.5, 0.9};
  options.gradient_shrinkage = 0;  // the right-hand side is minus the gradient
  for (const View& view : scene.views) {
    HostBuffer<S>& image = truth.emplace_back(static_cast<Index>(view.image.rgb.size()));
    std::copy(view.image.rgb.begin(), view.image.rgb.end(), image.begin());
    views.push_back({ToPosedCamera(view, NearPlane(scene)), image.view()});
  }
}

template struct RingProblem<float>;
template struct RingProblem<double>;

}  // namespace vesta::gs::test
