// SPDX-License-Identifier: Apache-2.0
// Estimates the exposures of the photographs of a scene.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/scenes/colmap.h"

namespace vesta::app {

// Luma of a colour, 0..1 (Rec. 601).
inline double Luma(double red, double green, double blue) { return 0.299 * red + 0.587 * green + 0.114 * blue; }

// Estimates the exposure of each view relative to the median view, in stops: factors of two of light, which is
// luma^2.2. The result is NaN for a view with fewer than 20 points.
//
// With tracks, the exposures of the views and the brightness of the points are medians of each other, computed in turn.
// Only views that see a point compare it, so foreground that hides points has no influence.
//
// Without tracks (an empty list), the light of the pixel of each point inside the image is divided by the light of the
// point's colour, which is the mean over its photographs. The exposure is the median of these ratios. It is 0 if the
// lower and the upper quartile differ in sign, as when foreground hides the points.
std::vector<double> ExposureStops(const gs::Scene& scene, const gs::PointTracks& tracks = {});

// By how much the brightness of the same object differs between photographs: the ratio of luma between the 95th and the
// 5th percentile of the views, minus 1. NaN with fewer than two known exposures. stops: from ExposureStops.
double ExposureSpread(const std::vector<double>& stops);

// A larger spread is worth fitting (docs/decisions/exposures.md).
inline constexpr double kExposureSpread = 0.1;

}  // namespace vesta::app
