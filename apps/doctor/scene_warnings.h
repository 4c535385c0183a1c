// SPDX-License-Identifier: Apache-2.0
// Warnings about a scene before training, from diagnostics of single photographs: sharpness, contrast, exposure.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// Diagnostics of a photograph that can be compared between the views of a scene.
struct ViewDiagnostics {
  double sharpness = 0;  // mean square Laplacian of the luma / its variance: low when blurred, independent of contrast
  double saturated = 0;  // fraction of the pixels with a saturated channel
  double contrast = 0;   // standard deviation of the luma, 0..1
  std::vector<float> thumbnail;  // kThumbnail x kThumbnail pixels of three channels, 0..1
};
inline constexpr int kThumbnail = 16;

// Luma of a colour, 0..1 (Rec. 601).
inline double Luma(double red, double green, double blue) { return 0.299 * red + 0.587 * green + 0.114 * blue; }

// image: not empty. Images wider than 640 pixels are first resized to that width, for comparable diagnostics.
ViewDiagnostics DiagnosticsOf(const gs::Image& image);

// Mean over pixels and channels of |a - b| of two thumbnails, 0..1.
double ThumbnailDistance(const ViewDiagnostics& a, const ViewDiagnostics& b);

// The exposure of each view relative to the median view, in stops (powers of two of light, luma^2.2). It is the median,
// over the points in the image, of the brightness of the pixel relative to the colour of the point. That colour is the
// mean over all photographs of the point, so the content of the image cancels out. 0 if the two quartiles of a view
// disagree in sign, as when foreground hides the points. NaN with fewer than 20 points.
std::vector<double> ExposureStops(const gs::Scene& scene);

// One line per warning, the most serious first; of warnings that many views share, the first five and the number of the
// others. Warns about few views, few points, views that see few points, views with equal poses, and photographs that
// are nearly identical, of one colour, blurred, of another exposure, or saturated. The images must be loadable.
// Warnings are hints: an intended photograph can cause them too.
std::vector<std::string> SceneWarnings(const gs::Scene& scene);

}  // namespace vesta::app
