// SPDX-License-Identifier: Apache-2.0
// Compares results of GPU and CPU (host) for a large workload (bench/kernel_times/workload.h).
#pragma once

#include "bench/kernel_times/workload.h"

namespace vesta::bench {

// Differences for the first view: its image, and the products J v and J^T u with its Jacobian J, for random v and u.
struct HostComparison {
  // |GPU - CPU| / |CPU|, with Euclidean norms.
  double image = 0, j_v = 0, jt_u = 0;
  // Values of all three whose bits differ between two runs on the GPU.
  Index differing = 0;

  // Bounds for arithmetic in float, where rounding may move an alpha across a threshold.
  static constexpr double kImageGoal = 1e-4, kProductGoal = 5e-4;
  // False if a difference is NaN.
  bool Agrees() const { return image < kImageGoal && j_v < kProductGoal && jt_u < kProductGoal && differing == 0; }
};

// Needs CPU memory for eight vectors of the model's size.
HostComparison CompareWithHost(const Workload& workload);

}  // namespace vesta::bench
