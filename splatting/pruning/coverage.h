// SPDX-License-Identifier: Apache-2.0
// Coverage: how much of what a camera could see of a Gaussian the training views show; and floaters, Gaussians that
// belong to no surface.
#pragma once

#include <vector>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/pruning/scoring_views.h"

namespace vesta::gs {

// What none of the training views shows, no photograph has asked for; it stands before cameras that come later
// (docs/decisions/coverage-pruning.md). In units of an image's area; opacity, and what stands before it, count in
// neither.
struct Coverage {
  double shown = 0;  // the sum over views of the integral of its falloff over the image
  // The integral of its falloff for a camera as far away as the nearest of the training views, that looks at its
  // broadest side: 2 pi times its two largest standard deviations; at most 1.
  double body = 0;

  // Small ones are none's concern: they hide little, and are many.
  bool IsUnderObserved() const {
    constexpr double kSmall = 0.003, kLeastPart = 0.03;
    return body > kSmall && shown < kLeastPart * body;
  }
};

// By Gaussian. Without images: of the cameras alone. Takes less time than rendering all views.
std::vector<Coverage> MeasureCoverage(const splat::Model<float>& model, const ScoringViews& judges);

// Which are wanting: what MeasureCoverage says of them, in a small part of its time, since few are large and most of
// these are well shown by the first views. Of Gaussians whose colours are finite; MeasureCoverage holds others for
// unseen.
std::vector<bool> WhichAreUnderObserved(const splat::Model<float>& model, const ScoringViews& judges);

// Those that the views do show, ascending; all where they show none.
std::vector<Index> Supported(const splat::Model<float>& model, const ScoringViews& judges);

// Floaters hang before or around what a splat shows. None is wrong for sure; these are signs of it, all far from what
// the Gaussians of a surface are like. The Gaussians that are left, ascending, and how many go for what; who has
// several reasons goes for the first.
struct FloaterCount {
  std::vector<Index> kept;
  // Of an opacity under 1/255, which is never drawn.
  Index faint = 0;
  // With a standard deviation longer than the model's median distance from its middle, and than its own: around all.
  Index huge = 0;
  // With no other nearer than ten times what is usual (the root of the mean squared distance to three, its median), nor
  // within reach of their falloff, six of their own longest standard deviations.
  Index isolated = 0;
  // Of which the views show hardly anything (Coverage::IsUnderObserved).
  Index unsupported = 0;
};

// judges: may be null; none is unsupported then.
FloaterCount FindFloaters(const SplatModel& model, const ScoringViews* judges);

}  // namespace vesta::gs
