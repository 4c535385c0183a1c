// SPDX-License-Identifier: Apache-2.0
// The updates of Adam on ranges of parameters and of Gaussians, compiled once per instruction set.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"
#include "splatting/adam/adam_formula.h"

namespace vesta::gs {

struct AdamRange {
  Index size;
  float *gradient, *parameters, *first, *second;  // the last two: moments; all of `size` values that do not overlap
  const float* units;                             // factors on the rate; null: 1
  float rate;                                     // divided by the first moment's bias correction
  float beta2;                                    // what the second moment keeps of itself
  float root_correction2;                         // 1 / sqrt(1 - beta2^steps)
};

struct AdamKernels {
  // parameters -= AdamStep at rate * units, the moments brought up to date; then gradient = 0, since it is at hand and
  // the next one is summed up from there. Memory bound: reads and writes 16 bytes a parameter, but only reads 4 where
  // the gradients of a whole vector are zero.
  void (*step)(const AdamRange& range);
  // BlockAdamStep and TurnBasis for the Gaussians [begin, end). A step reads and writes about 1.4 KiB of each.
  void (*step_blocks)(const BlockAdamArrays& arrays, Index begin, Index end);
  void (*turn_bases)(const BlockAdamArrays& arrays, Index begin, Index end);
};

// Compiled for an instruction set that the CPU has.
const AdamKernels& AdamKernelsFor(Isa isa);

}  // namespace vesta::gs
