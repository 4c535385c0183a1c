// What the splatting problem on a GPU does to its damping metric: what nvcc compiles.
#pragma once

#include "problems/gaussian_splatting/lm/length_metric.h"

namespace vesta::gs::device_metric {

// LengthMetric for all Gaussians. All pointers are to memory of the GPU; nothing waits.
void Complete(const LengthMetric<float>& lengths);

}  // namespace vesta::gs::device_metric
