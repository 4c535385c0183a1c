#include "bench/cameras/perturbed_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

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

using Views = std::vector<const gs::View*>;

// How these of the views stand in `found` beside where they are in `truth`, their best similarity apart.
std::vector<splat::CameraMotion> ApartFromSimilarity(double depth, const Views& truth, const Views& found,
                                                     const std::vector<std::size_t>& these) {
  Views of;
  std::vector<gs::ViewUnknowns> apart(these.size());
  for (std::size_t k = 0; k < these.size(); ++k) {
    of.push_back(truth[these[k]]);
    apart[k].motion = gs::MotionBetween(*truth[these[k]], *found[these[k]]);
  }
  constexpr int kRounds = 10;  // each takes out what is left, to first order
  for (int round = 0; round < kRounds; ++round) gs::RemoveCommonMotion(of, depth, &apart);
  std::vector<splat::CameraMotion> motions;
  motions.reserve(apart.size());
  for (const gs::ViewUnknowns& unknowns : apart) motions.push_back(unknowns.motion);
  return motions;
}

// The view and those that stand next to it.
std::vector<std::size_t> WithNearest(const Views& views, std::size_t view) {
  constexpr std::size_t kNearest = 8;
  std::vector<std::pair<double, std::size_t>> by_distance;
  const std::array<double, 3> centre = gs::CameraCenter(*views[view]);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::array<double, 3> other = gs::CameraCenter(*views[i]);
    const double distance = std::hypot(other[0] - centre[0], other[1] - centre[1], other[2] - centre[2]);
    by_distance.emplace_back(i == view ? -1.0 : distance, i);
  }
  std::ranges::sort(by_distance);
  by_distance.resize(std::min(by_distance.size(), kNearest + 1));
  std::vector<std::size_t> nearest;
  nearest.reserve(by_distance.size());
  for (const auto& [distance, i] : by_distance) nearest.push_back(i);
  return nearest;
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
  const Views true_views = gs::TrainingViews(truth.views);
  VESTA_CHECK(true_views.size() == found.size(), "{} training views, {} found", true_views.size(), found.size());
  std::vector<std::size_t> all(found.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const double depth = 2 * truth.extent;
  const std::vector<splat::CameraMotion> apart = ApartFromSimilarity(depth, true_views, found, all);
  const gs::SplatModel points = gs::InitializeFromPoints(truth.points, truth.extent, 0, 100'000);
  const auto shift = [&](std::size_t view, const splat::CameraMotion& motion) {
    gs::View seen = gs::MovedView(*true_views[view], motion);
    seen.camera = found[view]->camera;
    return gs::MedianShift(points, *true_views[view], seen, gs::NearPlane(truth));
  };
  std::vector<double> degrees, pixels, near;
  for (const std::size_t i : all) {
    degrees.push_back(apart[i].Angle() * 180 / std::numbers::pi);
    pixels.push_back(shift(i, apart[i]));
    near.push_back(shift(i, ApartFromSimilarity(depth, true_views, found, WithNearest(true_views, i)).front()));
  }
  const double most = *std::ranges::max_element(pixels);
  return {gs::Median(std::move(degrees)), gs::Median(std::move(pixels)), most, gs::Median(std::move(near))};
}

}  // namespace vesta::bench
