// SPDX-License-Identifier: Apache-2.0
// Measures whole iterations of the trainer on the GPU.
#pragma once

#include "bench/kernel_times/workload.h"

namespace vesta::bench {

struct StepCost {
  double seconds = 0;              // wall-clock time until all device work has ended
  double launches = 0, waits = 0;  // kernel launches, and waits of the host for the device
  double peak_gib = 0;             // peak device memory
};

// One iteration of the Adam stage without its history: the gradient of one view, the statistics for densification, and
// the step with block second moments. Returns the mean of `repeats` iterations over successive views, after three
// untimed ones.
StepCost AdamIterationCost(const Workload& workload, int repeats);

// One LM iteration on all views with 8 PCG iterations.
StepCost LmIterationCost(const Workload& workload);

}  // namespace vesta::bench
