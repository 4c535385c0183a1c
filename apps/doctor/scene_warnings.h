// SPDX-License-Identifier: Apache-2.0
// Warnings of `vesta doctor` about photographs, points and poses.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// Measurements of one photograph, comparable between the views of a scene.
struct ViewDiagnostics {
  // Mean squared Laplacian of the luma / variance of the luma: low for a blurred image, and independent of contrast.
  double sharpness = 0;
  double saturated = 0;          // fraction of the pixels with a saturated channel
  double contrast = 0;           // standard deviation of the luma, 0..1
  std::vector<float> thumbnail;  // three planes of kThumbnail x kThumbnail pixels, 0..1
};
inline constexpr int kThumbnail = 16;

// Luma of a colour, 0..1 (Rec. 601).
inline double Luma(double red, double green, double blue) { return 0.299 * red + 0.587 * green + 0.114 * blue; }

// Images wider than 640 pixels are first shrunk to that width, so that results are comparable. Throws Error for an
// empty image.
ViewDiagnostics DiagnosticsOf(const gs::Image& image);

// Mean absolute difference of two thumbnails over pixels and channels, 0..1.
double ThumbnailDistance(const ViewDiagnostics& a, const ViewDiagnostics& b);

// Estimates the exposure of each view relative to the median view, in stops: factors of two of light, which is
// luma^2.2. For each point inside the image, the light of its pixel is divided by the light of the point's colour. The
// point's colour is the mean over its photographs, so the content of the image has no influence. The exposure is the
// median of these ratios. It is 0 if the lower and the upper quartile differ in sign, as when foreground hides the
// points, and NaN with fewer than 20 points.
std::vector<double> ExposureStops(const gs::Scene& scene);

// One line per warning, the most serious kind first. A kind that affects many views names five of them and the number
// of the others. Warns about few views, few points, views that see few points, views with equal poses, and photographs
// that are nearly identical, of one colour, blurred, of another exposure, or saturated. Throws Error if a photograph
// cannot be read. Good photographs can cause warnings too.
std::vector<std::string> SceneWarnings(const gs::Scene& scene);

}  // namespace vesta::app
