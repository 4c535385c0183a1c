// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kernels/core/schema.h"
#include "kernels/gaussian_splatting/formulas/layout.h"

namespace vesta::gs {

// Adam's learning rates, for the photometric loss of one view as a mean over pixels and channels. Defaults as in the
// code of Kerbl et al. 2023 (3D Gaussian Splatting), for opacity as in later versions. The rate of positions is in each
// Gaussian's unit of length (length_units.h). LM derives its damping from these rates (lm/splat_blocks.h).
struct LearningRates {
  double position = 1.6e-4;
  double log_scale = 5e-3;  // logarithms of the standard deviations
  double quaternion = 1e-3;
  double opacity = 0.025;    // logit
  double sh_dc = 2.5e-3;     // spherical harmonics of degree 0
  double sh_rest = 1.25e-4;  // of higher degrees
};

const schema::Table<LearningRates>& LearningRateFields();

// Learning rate of an attribute of layout.h; for positions relative to the unit of length.
inline double RateOf(const LearningRates& rates, int attribute) {
  if (attribute < splat::kLogScale) return rates.position;
  if (attribute < splat::kQuaternion) return rates.log_scale;
  if (attribute < splat::kOpacity) return rates.quaternion;
  if (attribute < splat::kSh) return rates.opacity;
  return attribute < splat::kSh + 3 ? rates.sh_dc : rates.sh_rest;
}

}  // namespace vesta::gs
