// What a step of Adam multiplies: the same numbers wherever it is done.
#pragma once

#include "problems/gaussian_splatting/adam/block_adam_formula.h"
#include "problems/gaussian_splatting/adam/options.h"
#include "problems/gaussian_splatting/model/learning_rates.h"

namespace vesta::gs {

class AdamRule {
 public:
  AdamRule(const LearningRates& rates, AdamMetric metric) : rates_(rates), blocks_(metric == AdamMetric::kBlock) {}

  bool has_blocks() const { return blocks_; }
  // Attributes below this one are stepped in blocks, those from it on each parameter by itself.
  int first_diagonal() const { return blocks_ ? kBlockSize : 0; }

  // After so many steps: the factor on all rates over the first moment's bias correction, that times the rate of an
  // attribute, and the second moment's correction.
  static float StepFactor(double factor, int steps);
  float StepRate(int attribute, double factor, int steps) const;
  static float RootCorrection2(int steps);
  // The same for blocks; all pointers null, count 0.
  BlockAdamArrays BlockRates(double factor, int steps) const;

 private:
  LearningRates rates_;
  bool blocks_;
};

}  // namespace vesta::gs
