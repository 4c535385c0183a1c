// SPDX-License-Identifier: Apache-2.0
// Gaussians in an order in which neighbours in memory are neighbours in space.
#pragma once

#include <vector>

#include "kernels/core/span.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// The Gaussians of the model, those of each degree along a Z-order curve through their means (Morton 1966), 21 bits an
// axis: old indices in their new order. A view then sees and misses whole vectors of Gaussians, and the passes over all
// of them skip what it misses. Means that are not finite come last of their degree.
std::vector<Index> SpatialOrder(const SplatModel& model);

// Gaussian k of the result is Gaussian order[k] of the model. Throws Error where one has a higher degree than the one
// before it.
SplatModel InOrder(SplatModel model, const std::vector<Index>& order);

}  // namespace vesta::gs
