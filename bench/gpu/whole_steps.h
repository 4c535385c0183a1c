// SPDX-License-Identifier: Apache-2.0
// Measures whole iterations of the trainer on the GPU.
#pragma once

#include "bench/kernel_times/workload.h"

namespace vesta::bench {

// Cost of one iteration.
struct StepCost {
  double seconds = 0;              // wall-clock time until all GPU work has ended
  double launches = 0, waits = 0;  // kernel launches; number of times that the CPU waits for the GPU
  double peak_gib = 0;             // peak GPU memory
};

// Measures iterations of the Adam stage without evaluations: the gradient of one view, the statistics for
// densification, and the Adam step with second moments as blocks. Returns the mean of `repeats` iterations over
// successive views, after three that are not timed.
StepCost AdamIterationCost(const Workload& workload, int repeats);

// Measures one LM iteration on all views with 8 PCG iterations.
StepCost LmIterationCost(const Workload& workload);

}  // namespace vesta::bench
