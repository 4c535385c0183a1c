#include "kernels/core/launch.cuh"
#include "problems/gaussian_splatting/lm/device_metric.h"

namespace vesta::gs::device_metric {

void Complete(const LengthMetric<float>& lengths) { device::ForEach(lengths.count, lengths, "metric of lengths"); }

}  // namespace vesta::gs::device_metric
