// SPDX-License-Identifier: Apache-2.0
// Compares the results of GPU and host on a large workload.
#pragma once

#include "bench/kernel_times/workload.h"

namespace vesta::bench {

// Differences for the first view: image, J v and J^T u with random v and u.
struct HostComparison {
  // Relative differences |device - host| / |host|.
  double image = 0, j_v = 0, jt_u = 0;
  // Number of values of all three whose bits differ between two complete runs on the device.
  Index differing = 0;

  // Goals for float: rounding may move an alpha across a threshold.
  static constexpr double kImageGoal = 1e-4, kProductGoal = 5e-4;
  // False if a difference is NaN.
  bool Agrees() const { return image < kImageGoal && j_v < kProductGoal && jt_u < kProductGoal && differing == 0; }
};

// Needs host memory for eight vectors of parameters.
HostComparison CompareWithHost(const Workload& workload);

}  // namespace vesta::bench
