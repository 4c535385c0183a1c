// SPDX-License-Identifier: Apache-2.0
// One step of Adam for a whole model on the host.
#pragma once

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/model/learning_rates.h"
#include "splatting/adam/adam_formula.h"
#include "splatting/adam/adam_options.h"
#include "splatting/adam/block_bases.h"

namespace vesta::gs {

// The factors of a step of Adam.
//
// K views per step multiply the learning rate by sqrt(K). If gradients are mostly noise, the mean of the sum over K
// views grows like K, but its root mean square only like sqrt(K). A step with K views then moves as far as K steps with
// one view each (Malladi et al. 2022, "On the SDEs and scaling rules for adaptive gradient algorithms"). A step with K
// views decays the second moments by beta_2^K, like K steps, and the first moments by beta_1, like one step
// (docs/decisions/batch-size.md).
class AdamRule {
 public:
  AdamRule(const LearningRates& rates, SecondMoment metric, int views);

  bool has_blocks() const { return blocks_; }
  // Attributes below this index are updated in blocks (BlockAdamArrays), the others one by one.
  int first_diagonal() const { return blocks_ ? kBlockSize : 0; }

  int views() const { return views_; }
  // Factors of step number `steps` (from 1). factor: on all learning rates. StepFactor: factor * sqrt(views), divided
  // by the first moment's bias correction 1 - beta_1^steps. StepRate: StepFactor times the learning rate of an
  // attribute. RootCorrection2: 1 / sqrt(1 - beta_2^(K steps)), for the second moment.
  float StepFactor(double factor, int steps) const;
  float StepRate(int attribute, double factor, int steps) const;
  float RootCorrection2(int steps) const;
  // The same for steps in blocks; all pointers are null and the count is 0.
  BlockAdamArrays BlockRates(double factor, int steps) const;

 private:
  LearningRates rates_;
  bool blocks_;
  int views_;
  float beta2_;
};

// The arrays and factors of a step; all pointers are in one memory space.
struct AdamStepArrays {
  BlockAdamArrays blocks;  // arrays of the whole model, without the bases
  splat::ModelLayout layout;
  int first_diagonal;                 // attributes below it are updated in blocks
  int attributes;                     // number in use
  int views;                          // views of this step
  Index seen;                         // views of all steps, including this one
  float rate[splat::kMaxAttributes];  // AdamRule::StepRate of each attribute
};

template <class Space>
struct AdamSteps;

template <>
struct AdamSteps<Host> {
  // x -= step, updates the moments and sets the gradient to 0; then rotates the bases that are due.
  static void Run(const AdamStepArrays& arrays, BlockBases<Host>& bases);
};

}  // namespace vesta::gs
