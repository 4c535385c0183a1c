// SPDX-License-Identifier: Apache-2.0
// The input of the example: a scene, and simulated measurements of pairs of its views.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "kernels/core/random.h"
#include "views.h"

struct PairOptions {
  double rotation_noise = 1;   // root mean square, degrees
  double direction_noise = 2;  // root mean square, degrees
  double outliers = 0.1;       // fraction of pairs with a random rotation and direction
  double seed = 1;
};
constexpr int kCommonPoints = 20;  // pairs with fewer common points are left out

inline Vector3d NormalVector(vesta::CounterRandom& random) {
  const double x = random.Normal(), y = random.Normal(), z = random.Normal();
  return {x, y, z};
}

// Relative poses with noise, from the cameras of `data`. A program without known cameras would match the points of two
// images and estimate the essential matrix with RANSAC; repeated structures then make some pairs completely wrong.
inline std::vector<Pair> SimulatePairs(const BundleData& data, const PairOptions& options) {
  std::vector<std::vector<Index>> observers(data.num_points);
  for (const auto& o : data.observations) observers[o.point].push_back(o.camera);
  std::map<std::pair<Index, Index>, int> common_points;
  for (const std::vector<Index>& cameras : observers) {
    for (const Index a : cameras) {
      for (const Index b : cameras) {
        if (a < b) ++common_points[{a, b}];
      }
    }
  }
  const std::vector<View> views = ViewsOf(data);
  std::vector<Pair> pairs;
  for (const auto& [cameras, count] : common_points) {
    if (count < kCommonPoints) continue;
    const auto [a, b] = cameras;
    vesta::CounterRandom random(static_cast<std::uint64_t>(options.seed), a, b);
    const Vector3d turn = options.rotation_noise * kDegree / std::sqrt(3.0) * NormalVector(random);
    Vector3d shift = options.direction_noise * kDegree / std::sqrt(2.0) * NormalVector(random);
    Quaterniond noise(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()));
    if (random.Uniform() < options.outliers) {
      const Vector3d vector = NormalVector(random);
      noise = Quaterniond(random.Normal(), vector.x(), vector.y(), vector.z()).normalized();
      shift = 1e9 * NormalVector(random);
    }
    const Quaterniond to_a = views[a].rotation.conjugate();
    const Vector3d direction = to_a * (views[b].center - views[a].center).normalized();
    pairs.push_back({a, b, noise * to_a * views[b].rotation, (direction + shift).normalized()});
  }
  return pairs;
}

// Cameras on a circle around a cloud of points, which each observe half of the points with a noise of half a pixel.
inline BundleData GenerateScene() {
  BundleData data;
  data.num_cameras = 16, data.num_points = 400;
  data.x.resize(vesta::bundle::kCameraSize * data.num_cameras + vesta::bundle::kPointSize * data.num_points);
  vesta::CounterRandom random(1, 0);
  for (Index p = 0; p < data.num_points; ++p) PointOf(data, p) = NormalVector(random);
  for (Index i = 0; i < data.num_cameras; ++i) {
    const double angle = 2 * std::numbers::pi * i / data.num_cameras;
    const Vector3d center(8 * std::cos(angle), std::sin(3 * angle), 8 * std::sin(angle));
    double* camera = CameraOf(data, i);
    // The camera looks along its negative z axis, to the origin.
    SetView({Quaterniond::FromTwoVectors(Vector3d::UnitZ(), center), center}, camera);
    camera[6] = 800, camera[7] = -0.05, camera[8] = 0;
    for (Index p = 0; p < data.num_points; ++p) {
      if (random.Uniform() < 0.5) continue;
      const auto seen = Project(vesta::bundle::MakeCamera(camera), PointOf(data, p).data());
      const double u = seen.predicted[0] + 0.5 * random.Normal(), v = seen.predicted[1] + 0.5 * random.Normal();
      data.observations.push_back({static_cast<std::int32_t>(i), static_cast<std::int32_t>(p), {u, v}});
    }
  }
  return data;
}
