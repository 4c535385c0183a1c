// SPDX-License-Identifier: Apache-2.0
// Support: how much of what a camera could see of a Gaussian the training views do show. What none of them shows no
// photograph has asked for; it stands before cameras that come later (docs/results/2026-11-22-veils.md).
#pragma once

#include <vector>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "splatting/parsimony/judging_views.h"

namespace vesta::gs {

// In units of an image's area; opacity, and what stands before it, count in neither.
struct Support {
  double shown = 0;  // the sum over views of the integral of its falloff over the image
  // The integral of its falloff for a camera as far away as the nearest of the training views, that looks at its
  // broadest side: 2 pi times its two largest standard deviations; at most 1.
  double body = 0;

  // Small ones are none's concern: they hide little, and are many.
  bool is_wanting() const {
    constexpr double kSmall = 0.003, kLeastPart = 0.03;
    return body > kSmall && shown < kLeastPart * body;
  }
};

// By Gaussian. Without images: of the cameras alone. Takes less time than rendering all views.
std::vector<Support> MeasureSupport(const splat::Model<float>& model, const JudgingViews& judges);

// Which are wanting: what MeasureSupport says of them, in a small part of its time, since few are large and most of
// these are well shown by the first views. Of Gaussians whose colours are finite; MeasureSupport holds others for
// unseen.
std::vector<bool> WhichAreWanting(const splat::Model<float>& model, const JudgingViews& judges);

// Those that the views do show, ascending; all where they show none.
std::vector<Index> Supported(const splat::Model<float>& model, const JudgingViews& judges);

}  // namespace vesta::gs
