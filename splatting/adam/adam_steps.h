// One step of Adam over a whole model: the loops, of the host here, of a GPU in device_adam_steps.h.
#pragma once

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "splatting/adam/block_bases.h"

namespace vesta::gs {

// What a step works on; all pointers to one memory space.
struct AdamStepArrays {
  BlockAdamArrays blocks;  // the whole model's arrays; its bases are given apart
  splat::ModelLayout layout;
  int first_diagonal;  // attributes below it are stepped in blocks, of those from it on each parameter alone
  int attributes;      // in use
  int views;           // that this step is by
  Index seen;          // views of all steps, with this one
  float rate[splat::kMaxAttributes];  // of each attribute, AdamRule::StepRate
};

template <class Space>
struct AdamSteps;

template <>
struct AdamSteps<Host> {
  // x -= step, the moments brought up to date, gradient = 0; then bases are turned whose turn it is. Parallel.
  static void Run(const AdamStepArrays& arrays, BlockBases<Host>& bases);
};

}  // namespace vesta::gs
