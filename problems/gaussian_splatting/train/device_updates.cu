#include "kernels/core/launch.cuh"
#include "problems/gaussian_splatting/train/adam_formula.h"
#include "problems/gaussian_splatting/train/device_updates.h"
#include "problems/gaussian_splatting/train/screen_pull.h"

namespace vesta::gs::device_updates {
namespace {

// Memory bound: reads and writes 16 bytes a parameter.
struct StepOne {
  AdamArrays a;
  VESTA_HD void operator()(Index i) const {
    const Index attribute = i / a.count;
    const float unit = attribute < splat::kLogScale ? a.units[i - attribute * a.count] : 1.0f;
    const float step = AdamStep(a.gradient[i], unit * a.rate[attribute], a.root_correction2, a.first[i], a.second[i]);
    a.gradient[i] = 0;
    a.parameters[i] -= step;
  }
};

struct ObserveOne {
  Observation o;
  VESTA_HD void operator()(Index i) const {
    const std::int32_t rank = o.rank_of[i];
    if (rank < 0) return;
    o.pull[i] += ScreenPull(o.splats[rank], o.cotangents[rank].w, o.half_width, o.half_height);
    ++o.seen[i];
  }
};

}  // namespace

void StepAdam(const AdamArrays& arrays) {
  device::ForEach(arrays.attributes * arrays.count, StepOne{arrays}, "step of Adam");
}

void Observe(Index count, const Observation& observation) {
  device::ForEach(count, ObserveOne{observation}, "density statistics");
}

}  // namespace vesta::gs::device_updates
