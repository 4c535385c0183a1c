// The update of Adam on a range of parameters, compiled once per instruction set.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"

namespace vesta::gs {

inline constexpr float kAdamBeta1 = 0.9f, kAdamBeta2 = 0.999f;
// Added to the second moment at every step, it settles at 1e-27: its root takes the part of Adam's epsilon, and no
// moment ever becomes a denormal number, which would cost a hundred times the work.
inline constexpr float kAdamSecondFloor = 1e-30f, kAdamFirstFloor = 1e-30f;

struct AdamRange {
  Index size;
  float *gradient, *parameters, *first, *second;  // the last two: moments; all of `size` values that do not overlap
  float rate;                                     // divided by the first moment's bias correction
  float root_correction2;                         // 1 / sqrt(1 - beta2^steps)
};

// parameters -= rate * first / (sqrt(second) * root_correction2), the moments brought up to date first; then gradient =
// 0, since it is at hand and the next one is summed up from there. Memory bound: reads and writes 16 bytes a parameter.
using AdamUpdate = void (*)(const AdamRange& range);

// For an instruction set that the CPU has.
AdamUpdate AdamUpdateFor(Isa isa);

}  // namespace vesta::gs
