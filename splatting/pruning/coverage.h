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

// Coverage of a Gaussian, in units of an image's area. A large Gaussian that hardly any training view shows may hide
// the scene from new cameras (docs/decisions/coverage-pruning.md). Opacity and occlusion are ignored.
struct Coverage {
  // Integral of the Gaussian's falloff (1 at its centre) over the image, summed over the training views.
  double shown = 0;
  // The same integral in one camera that faces the broadest side of the Gaussian, at the distance of the nearest
  // training camera: 2 pi times the product of the two largest standard deviations; at most 1.
  double body = 0;

  static constexpr double kLeast = 0.03;

  // Whether the coverage shown / body is below kLeast. Small Gaussians are ignored: they occlude little.
  bool IsUnderObserved() const {
    constexpr double kSmall = 0.003;
    return body > kSmall && shown < kLeast * body;
  }
};

// Projects the Gaussians into all views; renders no image and needs no photographs.
std::vector<Coverage> MeasureCoverage(const splat::Model<float>& model, const ScoringViews& scoring_views);

// Coverage of under-observed Gaussians; zeros for all others. Much faster than MeasureCoverage: only large
// Gaussians are projected, each only until enough views have shown it. Colours must be finite. (Otherwise
// MeasureCoverage counts the Gaussian as unseen.)
std::vector<Coverage> CoverageOfUnderObserved(const splat::Model<float>& model, const ScoringViews& scoring_views);

// IsUnderObserved per Gaussian, from CoverageOfUnderObserved.
std::vector<bool> WhichAreUnderObserved(const splat::Model<float>& model, const ScoringViews& scoring_views);

// By how much to lower the logarithms of the two longer axes of each Gaussian; 0 for most, at most log(kMostShrinkage):
// * so that the coverage of an under-observed Gaussian becomes Coverage::kLeast, if its shown area stays the same;
// * by log(kMostShrinkage) if a camera is inside the Gaussian, where its opacity is at least kAlphaFloor. Such a
//   Gaussian is a film of haze, since cameras are in free space.
inline constexpr double kMostShrinkage = 1.6;  // a larger step would leave a gap that further training must fill
std::vector<float> LogShrinkage(const splat::Model<float>& model, const ScoringViews& scoring_views);

// Number of floaters by criterion; a floater counts for the first that it meets. `kept`: all other Gaussians,
// ascending. Gaussians on a surface are far from meeting any criterion.
struct FloaterCount {
  std::vector<Index> kept;
  // Opacity below 1/255: such a Gaussian is never drawn.
  Index faint = 0;
  // Surrounds the scene: its longest standard deviation exceeds its distance from the median of the means, and the
  // median of that distance over all Gaussians.
  Index huge = 0;
  // The root-mean-square distance from its three nearest neighbours exceeds ten times the median of this distance over
  // all Gaussians, and six times the Gaussian's longest standard deviation.
  Index isolated = 0;
  Index under_observed = 0;
};

// scoring_views: may be null; then `under_observed` is 0.
FloaterCount FindFloaters(const SplatModel& model, const ScoringViews* scoring_views);

}  // namespace vesta::gs
