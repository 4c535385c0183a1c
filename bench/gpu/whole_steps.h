// SPDX-License-Identifier: Apache-2.0
// Measures iterations of the trainer on the GPU.
#pragma once

#include "bench/kernel_times/workload.h"

namespace vesta::bench {

// Cost of one iteration.
struct StepCost {
  double seconds = 0;              // wall-clock, until all GPU work has ended
  double launches = 0, waits = 0;  // kernel launches; waits of the CPU for the GPU
  double peak_gib = 0;             // peak GPU memory
};

// Iterations of the Adam stage without evaluations: the gradient of one view, the statistics for densification, and the
// Adam step with block second moments. Mean of `repeats` iterations over successive views, after three untimed ones.
StepCost AdamIterationCost(const Workload& workload, int repeats);

// One LM iteration on all views with 8 PCG iterations.
StepCost LmIterationCost(const Workload& workload);

}  // namespace vesta::bench
