// SPDX-License-Identifier: Apache-2.0
// Adam's updates (adam_formula.h) for ranges of parameters and of Gaussians, compiled once per instruction set.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"
#include "splatting/adam/adam_formula.h"

namespace vesta::gs {

struct AdamRange {
  Index size;
  float *gradient, *parameters, *first, *second;  // all of `size`, not overlapping; first, second: moments
  const float* units;                             // factors on the learning rate; null: 1
  float rate;                                     // learning rate divided by the first moment's bias correction
  float beta2;                                    // decay of the second moment
  float root_correction2;                         // 1 / sqrt(1 - beta2^steps)
};

struct AdamKernels {
  // parameters -= AdamStep, with learning rate rate * units. Updates the moments and sets the gradient to zero. Memory
  // bound: reads and writes 16 bytes per parameter. If all gradients of a SIMD vector are zero, it reads 4 bytes per
  // parameter and writes nothing.
  void (*step)(const AdamRange& range);
  // Process the Gaussians [begin, end). A step reads and writes about 1.4 KiB per Gaussian.
  void (*step_blocks)(const BlockAdamArrays& arrays, Index begin, Index end);
  void (*rotate_bases)(const BlockAdamArrays& arrays, Index begin, Index end);
};

// The CPU must support the instruction set.
const AdamKernels& AdamKernelsFor(Isa isa);

}  // namespace vesta::gs
