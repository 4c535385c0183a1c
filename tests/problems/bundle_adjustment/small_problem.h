// SPDX-License-Identifier: Apache-2.0
// Small bundle adjustments for tests.
#pragma once

#include "bench/collections/generate_bundle.h"
#include "kernels/core/vector_backend.h"

namespace vesta::bundle {

using Cpu = CpuBackend<double>;

// All special cases for the passes: a camera and points without observations, a point that one camera observes twice, a
// point that all cameras observe, and numbers of observations that are no multiples of four.
inline BundleData SmallProblem() {
  BundleData data = Generate({.num_cameras = 8, .num_points = 40, .mean_track = 3, .seed = 3});
  const Observation twice = data.observations[5];
  data.observations.push_back(twice);
  data.observations.back().pixel[0] += 1.5;
  for (std::int32_t i = 0; i < 8; ++i) data.observations.push_back({i, 11, {10.0 * i, -20}});
  // A ninth camera like the first, and two more points, without observations.
  data.x.insert(data.x.begin() + 9 * data.num_cameras, data.x.begin(), data.x.begin() + 9);
  ++data.num_cameras;
  for (const double value : {0.1, 0.2, 0.3, -4.0, 5.0, 6.0}) data.x.push_back(value);
  data.num_points += 2;
  return data;
}

inline Cpu::Vector Start(const BundleData& data) {
  Cpu::Vector x(static_cast<Index>(data.x.size()));
  std::copy(data.x.begin(), data.x.end(), x.begin());
  return x;
}

}  // namespace vesta::bundle
