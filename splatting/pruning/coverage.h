// SPDX-License-Identifier: Apache-2.0
// Coverage: how much of each Gaussian the training views show. Floaters: Gaussians in free space that belong to no
// surface.
#pragma once

#include <vector>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/pruning/scoring_views.h"

namespace vesta::gs {

// Coverage of a Gaussian. If no training view shows a Gaussian, no photograph supports it, but it may hide the scene
// from new cameras (docs/decisions/coverage-pruning.md). In units of an image's area. Opacity and occlusion are
// ignored.
struct Coverage {
  double shown = 0;  // integral of its falloff over the image, summed over views
  // The same integral in a camera that faces its broadest side, from the distance of the nearest training camera. It is
  // 2 pi times its two largest standard deviations; at most 1.
  double body = 0;

  // Small Gaussians are ignored: they occlude little, and there are many.
  bool IsUnderObserved() const {
    constexpr double kSmall = 0.003, kLeastPart = 0.03;
    return body > kSmall && shown < kLeastPart * body;
  }
};

// The coverage of each Gaussian. Uses the cameras only, not the images. Faster than rendering all views.
std::vector<Coverage> MeasureCoverage(const splat::Model<float>& model, const ScoringViews& scoring_views);

// For each Gaussian, MeasureCoverage's IsUnderObserved in a small part of the time: few Gaussians are large, and the
// first views already show most of these. Colours must be finite; MeasureCoverage counts Gaussians with other colours
// as unseen.
std::vector<bool> WhichAreUnderObserved(const splat::Model<float>& model, const ScoringViews& scoring_views);

// The Gaussians that are not under-observed, in ascending order; all Gaussians if there would be none.
std::vector<Index> WellObserved(const splat::Model<float>& model, const ScoringViews& scoring_views);

// Floaters hide or surround the scene. Each criterion is only an indication, but Gaussians of a surface are far from
// all of them. `kept` has the other Gaussians in ascending order. The counts use the first criterion that a floater
// meets.
struct FloaterCount {
  std::vector<Index> kept;
  // Opacity below 1/255, which is never drawn.
  Index faint = 0;
  // A standard deviation longer than the model's median distance from its middle, and longer than its own distance: it
  // surrounds the scene.
  Index huge = 0;
  // Distance to its neighbours (root mean square over three) above ten times the median of the model, and above six of
  // its own longest standard deviations.
  Index isolated = 0;
  // Under-observed by the views (Coverage::IsUnderObserved).
  Index under_observed = 0;
};

// scoring_views: may be null; then `under_observed` is 0.
FloaterCount FindFloaters(const SplatModel& model, const ScoringViews* scoring_views);

}  // namespace vesta::gs
