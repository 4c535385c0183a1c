#include "bench/cameras/perturbed_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "kernels/core/check.h"
#include "kernels/core/random.h"
#include "kernels/math/quaternion.h"
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

splat::CameraMotion MotionBetween(const gs::View& from, const gs::View& to) {
  double Q[9], q[4];
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      Q[3 * i + j] = 0;
      for (std::size_t k = 0; k < 3; ++k) Q[3 * i + j] += to.rotation[3 * i + k] * from.rotation[3 * j + k];
    }
  }
  q[0] = std::sqrt(std::max(0.0, 1 + Q[0] + Q[4] + Q[8])) / 2;
  q[1] = (Q[7] - Q[5]) / (4 * q[0]), q[2] = (Q[2] - Q[6]) / (4 * q[0]), q[3] = (Q[3] - Q[1]) / (4 * q[0]);
  splat::CameraMotion motion;
  NormalizeQuaternion(q, motion.quaternion);
  for (int i = 0; i < 3; ++i) {
    motion.translation[i] = to.translation[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) motion.translation[i] -= Q[3 * i + k] * from.translation[static_cast<std::size_t>(k)];
  }
  return motion;
}

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
    const double gain = 1 + by.exposure * (2 * random.Uniform() - 1);
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
  for (std::size_t i = 0; i < found.size(); ++i) apart[i].motion = MotionBetween(*true_views[i], *found[i]);
  constexpr int kRounds = 10;  // each takes out what is left, to first order
  for (int round = 0; round < kRounds; ++round) gs::RemoveCommonMotion(true_views, 2 * truth.extent, &apart);
  const gs::SplatModel points = gs::InitializeFromPoints(truth.points, truth.extent, 0, 100'000);
  std::vector<double> degrees, pixels;
  for (std::size_t i = 0; i < found.size(); ++i) {
    degrees.push_back(apart[i].motion.Angle() * 180 / std::numbers::pi);
    pixels.push_back(gs::MedianShift(points, *true_views[i], apart[i].motion, gs::NearPlane(truth)));
  }
  const double most = *std::ranges::max_element(pixels);
  return {gs::Median(std::move(degrees)), gs::Median(std::move(pixels)), most};
}

}  // namespace vesta::bench
