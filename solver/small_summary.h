// SPDX-License-Identifier: Apache-2.0
// The result of a solve by SmallSolver or SolveEach.
#pragma once

#include "solver/summary.h"

namespace vesta {

struct SmallSummary {
  // The statuses have the meaning that they have for SolveLm.
  LmStatus status = LmStatus::kRunning;
  double initial_cost = 0, final_cost = 0;  // 1/2 |r|^2 at the start and at the returned point
  int num_accepted = 0, num_rejected = 0;   // iterations
  double gradient_max_norm = 0;             // max |g| at the last point whose gradient was tested
};

}  // namespace vesta
