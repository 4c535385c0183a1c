// What a step of Adam multiplies: the same numbers wherever it is done.
//
// By K views at once a step is longer by the root of K. Where views differ by more than they agree, the root of the
// second moment of their sum grows with the root of K and the sum with K, so that K views lead as far as they would
// have one by one (Malladi et al. 2022, "On the SDEs and scaling rules for adaptive gradient algorithms"). The second
// moments decay as they would have, the first as ever (docs/results/2026-11-25-views-an-iteration.md).
#pragma once

#include "problems/gaussian_splatting/model/learning_rates.h"
#include "splatting/adam/block_adam_formula.h"
#include "splatting/adam/options.h"

namespace vesta::gs {

class AdamRule {
 public:
  // views: that each step is by.
  AdamRule(const LearningRates& rates, AdamMetric metric, int views);

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

}  // namespace vesta::gs
