#include "problems/gaussian_splatting/adam/adam_rule.h"

#include <cmath>

namespace vesta::gs {

float AdamRule::StepFactor(double factor, int steps) const {
  return static_cast<float>(factor * std::sqrt(views_) / (1 - std::pow(double{kAdamBeta1}, steps)));
}

float AdamRule::StepRate(int attribute, double factor, int steps) const {
  return static_cast<float>(RateOf(rates_, attribute) * StepFactor(factor, steps));
}

float AdamRule::RootCorrection2(int steps) {
  return static_cast<float>(1 / std::sqrt(1 - std::pow(double{kAdamBeta2}, steps)));
}

BlockAdamArrays AdamRule::BlockRates(double factor, int steps) const {
  BlockAdamArrays arrays{};
  for (int k = 0; k < kBlockSize; ++k) arrays.rates[k] = static_cast<float>(RateOf(rates_, k));
  arrays.step = StepFactor(factor, steps);
  arrays.root_correction2 = RootCorrection2(steps);
  return arrays;
}

}  // namespace vesta::gs
