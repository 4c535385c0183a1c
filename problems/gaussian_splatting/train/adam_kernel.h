// The update of Adam on a range of parameters, compiled once per instruction set.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"
#include "problems/gaussian_splatting/train/adam_formula.h"

namespace vesta::gs {

struct AdamRange {
  Index size;
  float *gradient, *parameters, *first, *second;  // the last two: moments; all of `size` values that do not overlap
  const float* units;                             // factors on the rate; null: 1
  float rate;                                     // divided by the first moment's bias correction
  float root_correction2;                         // 1 / sqrt(1 - beta2^steps)
};

// parameters -= rate * units * first / (sqrt(second) * root_correction2), the moments brought up to date first; then
// gradient = 0, since it is at hand and the next one is summed up from there. Memory bound: reads and writes 16 bytes a
// parameter.
using AdamUpdate = void (*)(const AdamRange& range);

// For an instruction set that the CPU has.
AdamUpdate AdamUpdateFor(Isa isa);

}  // namespace vesta::gs
