// SPDX-License-Identifier: Apache-2.0
// Models whose Gaussians have harmonics of different degrees.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// Gaussian k of a model to be is Gaussian source[k] of the one there is, without the bands that the layout leaves out,
// and with zeros in those that only the layout has.
struct DegreeOrder {
  std::vector<std::uint32_t> source;
  splat::ModelLayout layout;
};

// The order that gives each Gaussian the degree; among those of one degree it stays. Throws Error unless there is a
// degree for each, none above the one it has.
DegreeOrder OrderByDegree(const splat::ModelLayout& layout, const std::vector<std::uint8_t>& degrees);

// The layout of these Gaussians of a model. Throws Error where one has a higher degree than the one before it.
splat::ModelLayout LayoutOfRows(const splat::ModelLayout& layout, const std::vector<std::uint32_t>& source);

// The model that the order makes of this one.
SplatModel TakeGaussians(SplatModel model, const DegreeOrder& order);

// The model with the bands that Gaussians lack as zeros: all have its highest degree, in the order there is.
SplatModel AtOneDegree(SplatModel model);

// The degrees that the numbers of a model tell, as those of a file do: of each Gaussian that of its highest band that
// is not zero. Where a band is zero in all of them it was not trained yet, and all keep the degree they have.
std::vector<std::uint8_t> StoredDegrees(const SplatModel& model);

// The model with those.
SplatModel AtStoredDegrees(SplatModel model);

}  // namespace vesta::gs
