// SPDX-License-Identifier: Apache-2.0
// Whole iterations of the trainer on the GPU, as a user waits for them.
#pragma once

#include "bench/kernel_times/workload.h"

namespace vesta::bench {

struct StepCost {
  double seconds = 0;              // of the clock, to the end of all work
  double launches = 0, waits = 0;  // of the host
  double peak_gib = 0;             // memory of the device
};

// One iteration of the Adam stage without its records: the gradient of one view with what density control observes, and
// the step in blocks. The mean of `repeats`, after three that are not counted; view after view.
StepCost AdamIterationCost(const Workload& workload, int repeats);

// One iteration of LM with 8 products, all views.
StepCost LmIterationCost(const Workload& workload);

}  // namespace vesta::bench
