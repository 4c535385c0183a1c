#include "splatting/adam/adam_rule.h"

#include <cmath>

namespace vesta::gs {

AdamRule::AdamRule(const LearningRates& rates, AdamMetric metric, int views)
    : rates_(rates),
      blocks_(metric == AdamMetric::kBlock),
      views_(views),
      beta2_(static_cast<float>(std::pow(double{kAdamBeta2}, views))) {}

float AdamRule::StepFactor(double factor, int steps) const {
  return static_cast<float>(factor * std::sqrt(views_) / (1 - std::pow(double{kAdamBeta1}, steps)));
}

float AdamRule::StepRate(int attribute, double factor, int steps) const {
  return static_cast<float>(RateOf(rates_, attribute) * StepFactor(factor, steps));
}

float AdamRule::RootCorrection2(int steps) const {
  return static_cast<float>(1 / std::sqrt(1 - std::pow(double{beta2_}, steps)));
}

BlockAdamArrays AdamRule::BlockRates(double factor, int steps) const {
  BlockAdamArrays arrays{};
  for (int k = 0; k < kBlockSize; ++k) arrays.rates[k] = static_cast<float>(RateOf(rates_, k));
  arrays.step = StepFactor(factor, steps);
  arrays.beta2 = beta2_;
  arrays.root_correction2 = RootCorrection2(steps);
  return arrays;
}

}  // namespace vesta::gs
