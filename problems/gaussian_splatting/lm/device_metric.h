// What the splatting problem on a GPU does to its damping metric: what nvcc compiles.
#pragma once

#include "problems/gaussian_splatting/lm/turn_metric.h"

namespace vesta::gs::device_metric {

// AddTurnMetric for all Gaussians. All pointers are to memory of the GPU; nothing waits.
void AddTurns(const AddTurnMetric<float>& turns);

}  // namespace vesta::gs::device_metric
