// SPDX-License-Identifier: Apache-2.0
#include "tests/support/splat_scenes.h"

#include "kernels/gaussian_splatting/lenses/models.h"
#include "kernels/math/quaternion.h"

namespace vesta::test {
namespace {

double Logit(double p) { return std::log(p / (1 - p)); }

}  // namespace

splat::PosedCamera RandomView(Random& random, int width, int height) {
  splat::PosedCamera view{};
  const double quaternion[4] = {random.Normal(), random.Normal(), random.Normal(), random.Normal()};
  RotationFromQuaternion(quaternion, view.R);
  for (double& t : view.T) t = random.Normal();
  for (int i = 0; i < 3; ++i) {
    view.centre[i] = -(view.R[i] * view.T[0] + view.R[3 + i] * view.T[1] + view.R[6 + i] * view.T[2]);
  }
  view.width = width, view.height = height;
  view.lens.fx = random.Uniform(0.8, 1.5) * std::max(width, height);
  view.lens.fy = random.Uniform(0.9, 1.1) * view.lens.fx;
  view.lens.cx = random.Uniform(0.3, 0.7) * width, view.lens.cy = random.Uniform(0.3, 0.7) * height;
  view.near = 0.01;
  Random of_filter = random;  // a copy: later random values do not change
  view.eps2d = of_filter.LogUniform(0.03, 1);
  view.antialiased = of_filter.Uniform(0, 1) < 0.5;
  return view;
}

Scene EmptyScene(const splat::PosedCamera& view, int count, int sh_degree) {
  Scene scene;
  scene.view = view;
  scene.count = count;
  scene.sh_degree = scene.active_sh_degree = sh_degree;
  scene.x.resize(static_cast<std::size_t>(Index{splat::NumAttributes(sh_degree)} * count));
  return scene;
}

Scene RandomScene(const SceneOptions& options, std::uint64_t seed) {
  Random random(seed);
  return RandomScene(RandomView(random, options.width, options.height), options, random);
}

Scene RandomScene(const splat::PosedCamera& view, const SceneOptions& options, Random& random) {
  Scene scene = EmptyScene(view, options.count, options.sh_degree);
  const int attributes = splat::NumAttributes(options.sh_degree);
  const auto pixel = [&](int size) { return random.Uniform(-options.border * size, (1 + options.border) * size); };
  for (int i = 0; i < options.count; ++i) {
    const double z = random.LogUniform(1, 5) * (random.Uniform(0, 1) < options.behind ? -1 : 1);
    const double u = pixel(view.width), v = pixel(view.height);
    double t[3];
    splat::PointAt(view.lens, u, v, z, t);
    for (int k = 0; k < 3; ++k) t[k] -= view.T[k];
    const double sigma = random.LogUniform(options.sigma_min, options.sigma_max) * std::abs(z) / view.lens.fx;
    for (int k = 0; k < 3; ++k) {
      scene.At(splat::kMean + k, i) = view.R[k] * t[0] + view.R[3 + k] * t[1] + view.R[6 + k] * t[2];
      scene.At(splat::kLogScale + k, i) = std::log(k == 0 ? sigma : sigma / random.LogUniform(1, options.aspect_max));
    }
    const double length = random.LogUniform(0.3, 3);
    for (int k = 0; k < 4; ++k) scene.At(splat::kQuaternion + k, i) = length * random.Normal();
    scene.At(splat::kOpacity, i) = Logit(random.Uniform(options.opacity_min, options.opacity_max));
    for (int a = 0; a < attributes - splat::kSh; ++a) {
      // Around 0.1 to 1 with some directional change; a few below the clamp at zero.
      scene.At(splat::kSh + a, i) = a < 3 ? random.Uniform(-1.4, 1.8) : 0.15 * random.Normal();
    }
  }
  for (double& value : scene.x) value = static_cast<float>(value);
  return scene;
}

Scene WithBands(const Scene& scene, const std::int64_t (&with_band)[splat::kMaxShDegree + 1]) {
  const splat::ModelLayout layout = splat::LayoutOfBands(with_band);
  Scene result = scene;
  result.x = RemoveMissingBands(scene.x, layout);
  result.sh_degree = layout.sh_degree;
  result.active_sh_degree = std::min(scene.active_sh_degree, layout.sh_degree);
  std::copy_n(layout.without_band, splat::kMaxShDegree, result.without_band);
  return result;
}

std::vector<SceneOptions> SceneKinds() {
  std::vector<SceneOptions> kinds;
  const auto add = [&](const char* name) -> SceneOptions& {
    kinds.emplace_back();
    kinds.back().name = name;
    return kinds.back();
  };
  add("Plain");
  {
    SceneOptions& k = add("OnePixel");
    k.width = k.height = 1, k.border = 1;
  }
  {
    SceneOptions& k = add("Strip");
    k.width = 100, k.height = 3, k.sh_degree = 2;
  }
  {
    SceneOptions& k = add("WholeTiles");
    k.width = 48, k.height = 32, k.count = 150, k.sh_degree = 1;
  }
  {
    SceneOptions& k = add("CappedAndClosed");
    k.count = 120, k.sigma_min = 5, k.sigma_max = 20, k.opacity_min = 0.9, k.opacity_max = 0.99999, k.sh_degree = 0;
  }
  {
    SceneOptions& k = add("AllOpaque");
    k.count = 120, k.sigma_min = 20, k.sigma_max = 100, k.aspect_max = 2;
    k.opacity_min = 0.99, k.opacity_max = 0.99999, k.sh_degree = 0, k.extreme = true;
  }
  {
    SceneOptions& k = add("ManyLayers");
    k.count = 300, k.sigma_min = 5, k.sigma_max = 20, k.aspect_max = 2;
    k.opacity_min = 0.02, k.opacity_max = 0.4, k.sh_degree = 1;
  }
  {
    SceneOptions& k = add("SubPixel");
    k.count = 200, k.sigma_min = 1e-3, k.sigma_max = 0.5;
  }
  {
    SceneOptions& k = add("LargerThanTheImage");
    k.count = 20, k.sigma_min = 50, k.sigma_max = 2000, k.opacity_max = 0.6;
  }
  {
    SceneOptions& k = add("Needles");
    k.count = 60, k.sigma_min = 10, k.sigma_max = 200, k.aspect_max = 1e3;
  }
  {
    SceneOptions& k = add("BehindAndBeyond");
    k.count = 200, k.border = 1, k.behind = 0.3, k.sigma_min = 3, k.sigma_max = 30;
  }
  return kinds;
}

}  // namespace vesta::test
