// SPDX-License-Identifier: Apache-2.0
// Learning rates by class of parameter.
#pragma once

#include "kernels/core/schema.h"
#include "kernels/gaussian_splatting/formulas/layout.h"

namespace vesta::gs {

// Adam's learning rates by class of parameter, for the mean photometric loss of one view (Kerbl et al. 2023, the
// authors' code; opacity as in later versions of that code). Positions are in units of length (length_units.h). LM uses
// the rates as its damping metric.
struct LearningRates {
  double position = 1.6e-4;
  double log_scale = 5e-3;
  double quaternion = 1e-3;
  double opacity = 0.025;
  double sh_dc = 2.5e-3;
  double sh_rest = 1.25e-4;
};

const schema::Table<LearningRates>& LearningRateFields();

// Learning rate of attribute a (kernels/gaussian_splatting/formulas/layout.h); for positions in units of length.
inline double RateOf(const LearningRates& rates, int attribute) {
  if (attribute < splat::kLogScale) return rates.position;
  if (attribute < splat::kQuaternion) return rates.log_scale;
  if (attribute < splat::kOpacity) return rates.quaternion;
  if (attribute < splat::kSh) return rates.opacity;
  return attribute < splat::kSh + 3 ? rates.sh_dc : rates.sh_rest;
}

}  // namespace vesta::gs
