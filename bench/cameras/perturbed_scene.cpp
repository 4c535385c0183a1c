#include "bench/cameras/perturbed_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "kernels/core/check.h"
#include "kernels/core/random.h"
#include "problems/gaussian_splatting/cameras/gauge.h"
#include "problems/gaussian_splatting/cameras/moved_view.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "problems/gaussian_splatting/model/median.h"
#include "problems/gaussian_splatting/model/to_kernel.h"

namespace vesta::bench {
namespace {

std::array<double, 3> Direction(CounterRandom& random) {
  std::array<double, 3> v{random.Normal(), random.Normal(), random.Normal()};
  const double length = std::hypot(v[0], v[1], v[2]);
  for (double& x : v) x /= length;
  return v;
}

}  // namespace

gs::Scene Perturbed(const gs::Scene& scene, const Perturbation& by, std::uint64_t seed,
                    std::vector<double>* true_gains) {
  gs::Scene perturbed = scene;
  true_gains->clear();
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    CounterRandom random(seed, v);
    const std::array<double, 3> axis = Direction(random), way = Direction(random);
    splat::PoseTangent xi;
    for (std::size_t k = 0; k < 3; ++k) {
      xi.v[k] = axis[k] * by.degrees * std::numbers::pi / 180;
      xi.v[3 + k] = way[k] * by.centre * 2 * scene.extent;
    }
    gs::View& view = perturbed.views[v];
    splat::MovePose(splat::Compose(xi, {}), view.rotation.data(), view.translation.data());
    view.camera.lens.fx *= 1 + by.focal, view.camera.lens.fy *= 1 + by.focal;
    const double gain = view.is_test() ? 1 : 1 + by.exposure * (2 * random.Uniform() - 1);
    for (float& value : view.image.rgb) value *= static_cast<float>(gain);
    true_gains->push_back(gain);
  }
  return perturbed;
}

PoseError ErrorOf(const gs::Scene& truth, const std::vector<const gs::View*>& found) {
  std::vector<const gs::View*> true_views;
  for (const gs::View& view : truth.views) {
    if (view.is_trained()) true_views.push_back(&view);
  }
  VESTA_CHECK(true_views.size() == found.size(), "{} training views, {} found", true_views.size(), found.size());
  std::vector<gs::ViewUnknowns> apart(found.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    apart[i].motion = gs::MotionBetween(*true_views[i], *found[i]);
  }
  constexpr int kRounds = 10;  // each takes out what is left, to first order
  for (int round = 0; round < kRounds; ++round) gs::RemoveCommonMotion(true_views, 2 * truth.extent, &apart);
  const gs::SplatModel points = gs::InitializeFromPoints(truth.points, truth.extent, 0, 100'000);
  std::vector<double> degrees, pixels;
  for (std::size_t i = 0; i < found.size(); ++i) {
    degrees.push_back(apart[i].motion.Angle() * 180 / std::numbers::pi);
    gs::View seen = gs::MovedView(*true_views[i], apart[i].motion);
    seen.camera = found[i]->camera;
    pixels.push_back(gs::MedianShift(points, *true_views[i], seen, gs::NearPlane(truth)));
  }
  const double most = *std::ranges::max_element(pixels);
  return {gs::Median(std::move(degrees)), gs::Median(std::move(pixels)), most};
}

}  // namespace vesta::bench
