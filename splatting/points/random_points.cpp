// SPDX-License-Identifier: Apache-2.0
#include "splatting/points/random_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/lenses/models.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/points/likely_depths.h"

namespace vesta::gs {
namespace {

using Vector = std::array<double, 3>;

constexpr float kHalfSideOfCube = 1.3f;

// Portable random numbers: std::uniform_real_distribution differs between standard libraries.
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : generator_(seed) {}
  float operator()() { return static_cast<float>(generator_() >> 40) * 0x1p-24f; }
  std::array<float, 3> Color() {
    std::array<float, 3> color;
    for (float& v : color) v = (*this)();
    return color;
  }

 private:
  std::mt19937_64 generator_;
};

// The training views of known size; all views of known size if there are none.
std::vector<View> UsableViews(const std::vector<View>& views) {
  std::vector<View> training, all;
  for (const View& view : views) {
    if (view.camera.width == 0) continue;
    all.push_back(view);
    if (view.is_trained()) training.push_back(view);
  }
  return training.empty() ? all : training;
}

// Whether the camera is outside the cube and its optical axis passes through it.
bool FacesCube(const View& view) {
  const Vector center = CameraCenter(view);
  // The part [enter, leave] of the axis, in units of length ahead of the camera, that is between all six planes.
  double enter = -std::numeric_limits<double>::infinity(), leave = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < 3; ++j) {
    const double forward = view.rotation[6 + j];
    if (forward == 0) {
      if (std::abs(center[j]) > double{kHalfSideOfCube}) return false;
      continue;
    }
    const double a = (-double{kHalfSideOfCube} - center[j]) / forward,
                 b = (double{kHalfSideOfCube} - center[j]) / forward;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter > 0 && enter < leave;
}

}  // namespace

WorldPoints PointsInCube(const RandomPoints& random) {
  Uniform uniform(random.seed);
  WorldPoints cloud;
  for (Index i = 0; i < random.count; ++i) {
    std::array<double, 3> position;
    for (double& v : position) v = static_cast<double>(kHalfSideOfCube * (2 * uniform() - 1));
    cloud.positions.push_back(position);
    cloud.colors.push_back(uniform.Color());
  }
  return cloud;
}

WorldPoints PointsInViews(const std::vector<View>& views, const RandomPoints& random) {
  constexpr double kSpread = 3;  // depths range from 1/kSpread to kSpread times the likely depth
  const std::vector<View> training = UsableViews(views);
  VESTA_CHECK(!training.empty(), "random points need a view of known size");
  const std::vector<double> depths = LikelyDepths(training);
  Uniform uniform(random.seed);
  WorldPoints cloud;
  for (Index i = 0; i < random.count; ++i) {
    const auto k = static_cast<std::size_t>(i) % training.size();
    const View& view = training[k];
    const double u = static_cast<double>(uniform()) * view.camera.width;
    const double v = static_cast<double>(uniform()) * view.camera.height;
    const double depth = depths[k] * std::pow(kSpread, 2 * static_cast<double>(uniform()) - 1);
    Vector in_camera;
    splat::PointAt(view.camera.lens, u, v, depth, in_camera.data());
    Vector position;
    for (std::size_t j = 0; j < 3; ++j) {
      position[j] = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        position[j] += view.rotation[3 * c + j] * (in_camera[c] - view.translation[c]);
      }
      if (!(std::abs(position[j]) <= static_cast<double>(std::numeric_limits<float>::max()))) {
        Fail(kBadFile, "{}: its camera is too far away for random points in its view; add points to the model",
             view.name);
      }
    }
    cloud.positions.push_back(position);
    cloud.colors.push_back(uniform.Color());
  }
  return cloud;
}

WorldPoints PointsForCameras(const std::string& source, const RandomPoints& random, Scene* scene) {
  const bool in_cube = std::ranges::all_of(UsableViews(scene->views), FacesCube);
  scene->points_note =
      fmt::format("{} has no points: {} random points are used instead, {}", source, random.count,
                  in_cube ? "in the cube from -1.3 to 1.3, because all cameras face it" : "in the cameras' views");
  scene->notes.push_back(scene->points_note);
  return in_cube ? PointsInCube(random) : PointsInViews(scene->views, random);
}

}  // namespace vesta::gs
