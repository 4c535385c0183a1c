// SPDX-License-Identifier: Apache-2.0
// Differences of exposure between the photographs of a scene.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// Exposure of a view relative to the median view, in stops: factors of two of light, which is luma^2.2.
struct ViewExposure {
  double stops = 0;  // NaN with fewer than 20 points
  // Whether three quarters of the points agree on the sign. They do not if the difference is small, or if foreground
  // hides the points.
  bool is_certain = false;
};

// For each point inside the image, the light of its pixel is divided by the light of the point's colour. The point's
// colour is the mean over its photographs, so the content of the image has no influence. The exposure is the median of
// these ratios. Throws Error if a photograph cannot be read.
std::vector<ViewExposure> ExposuresOf(const gs::Scene& scene);

// The difference of the 90th and the 10th percentile of the exposures, in stops; 0 with fewer than five known ones.
double ExposureSpread(const std::vector<ViewExposure>& exposures);

// By how much light changes over this number of stops, in percent.
double LightPercent(double stops);

}  // namespace vesta::app
