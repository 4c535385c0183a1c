// SPDX-License-Identifier: Apache-2.0
// What each Gaussian of a model is worth: by how much the photometric cost of the training views rises without it
// (kernels/gaussian_splatting/raster/removal_pass.h).
#pragma once

#include <vector>

#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "splatting/parsimony/judging_views.h"

namespace vesta::gs {

// Costs are sums over views, pixels and channels of the loss that trainings lower: 0.8 |e| + 0.2 (1 - SSIM).
struct Worth {
  double cost = 0;           // of the views with all Gaussians
  double values = 0;         // pixels of the views, by channel
  std::vector<double> rise;  // by Gaussian: when it goes and all others stay as they are; negative: better without
};

// Takes about three times as long as rendering all views.
Worth MeasureWorth(const splat::Model<float>& model, const JudgingViews& judges);

}  // namespace vesta::gs
