#include "kernels/core/launch.cuh"
#include "problems/gaussian_splatting/lm/device_metric.h"

namespace vesta::gs::device_metric {

void AddTurns(const AddTurnMetric<float>& turns) { device::ForEach(turns.count, turns, "metric of turns"); }

}  // namespace vesta::gs::device_metric
