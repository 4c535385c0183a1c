// SPDX-License-Identifier: Apache-2.0
// Whether the GPU computes at scale what the host computes.
#pragma once

#include "bench/kernel_times/workload.h"

namespace vesta::bench {

// Of the first view: image, J v and J^T u for one v and one u of random numbers.
struct HostComparison {
  // |device - host| / |host|.
  double image = 0, j_v = 0, jt_u = 0;
  // Values of all three whose bits differ between two runs on the device, each from the list of splats on.
  Index differing = 0;

  // In float, where an alpha within rounding of a threshold may fall the other way.
  static constexpr double kImageGoal = 1e-4, kProductGoal = 5e-4;
  // NaN does not agree.
  bool Agrees() const { return image < kImageGoal && j_v < kProductGoal && jt_u < kProductGoal && differing == 0; }
};

// Takes memory of the host for eight vectors of parameters.
HostComparison CompareWithHost(const Workload& workload);

}  // namespace vesta::bench
