// SPDX-License-Identifier: Apache-2.0
// One step of Adam over a whole model on the host: its factors and its loops.
#pragma once

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/model/learning_rates.h"
#include "splatting/adam/adam_formula.h"
#include "splatting/adam/adam_options.h"
#include "splatting/adam/block_bases.h"

namespace vesta::gs {

// What a step of Adam multiplies: the same numbers wherever it is done.
//
// By K views at once a step is longer by the root of K. Where views differ by more than they agree, the root of the
// second moment of their sum grows with the root of K and the sum with K, so that K views lead as far as they would
// have one by one (Malladi et al. 2022, "On the SDEs and scaling rules for adaptive gradient algorithms"). The second
// moments decay as they would have, the first as ever (docs/decisions/batch-size.md).
class AdamRule {
 public:
  // views: that each step is by.
  AdamRule(const LearningRates& rates, SecondMoment metric, int views);

  bool has_blocks() const { return blocks_; }
  // Attributes below this one are stepped in blocks, those from it on each parameter by itself.
  int first_diagonal() const { return blocks_ ? kBlockSize : 0; }

  int views() const { return views_; }
  // After so many steps: the factor on all rates over the first moment's bias correction, that times the rate of an
  // attribute, and the second moment's correction.
  float StepFactor(double factor, int steps) const;
  float StepRate(int attribute, double factor, int steps) const;
  float RootCorrection2(int steps) const;
  // The same for blocks; all pointers null, count 0.
  BlockAdamArrays BlockRates(double factor, int steps) const;

 private:
  LearningRates rates_;
  bool blocks_;
  int views_;
  float beta2_;
};

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
