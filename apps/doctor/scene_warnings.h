// SPDX-License-Identifier: Apache-2.0
// What is odd about a scene before anything is trained on it, and the signs of it in single views: sharpness, contrast,
// exposure.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// What a photograph shows of how it was taken, in a few figures that can be compared between the views of a scene.
struct ViewDiagnostics {
  double sharpness = 0;  // mean square of the Laplacian of the luma, by its variance; blur lowers it, contrast does not
  double burnt = 0;      // part of the pixels with a channel at its top, 0..1
  double contrast = 0;   // standard deviation of the luma, 0..1
  std::vector<float> thumbnail;  // kThumbnail x kThumbnail pixels of three channels, 0..1
};
inline constexpr int kThumbnail = 16;

// Of a colour, 0..1 (Rec. 601).
inline double Luma(double red, double green, double blue) { return 0.299 * red + 0.587 * green + 0.114 * blue; }

// Of an image with pixels. Large ones are made 640 pixels wide first, so that figures of one scene are of one scale.
ViewDiagnostics DiagnosticsOf(const gs::Image& image);

// Mean over pixels and channels of |a - b| of two thumbnails, 0..1.
double ThumbnailDistance(const ViewDiagnostics& a, const ViewDiagnostics& b);

// Of each view, in stops (factors of two of light, by luma^2.2) beside the median view: the median over the points that
// lie in its image of how much lighter its pixel is than the point's colour, which is the mean of all photographs that
// found it. So it tells the exposure, not what the picture is of. 0 where the quarters
// of its points do not agree which way: then things before the points are seen. NaN with fewer than 20 of them.
std::vector<double> ExposureStops(const gs::Scene& scene);

// A line for each thing, most telling first; of things that many views share, the first few and how many more. Looked
// for: few views, few points, views that see few of the points, photographs of one colour, that are nearly the same as
// another, blurred, or darker or lighter than the others, or burnt out, and views at one place that look one way. The
// images must be there. These are signs, and a photograph that is meant so shows them too.
std::vector<std::string> SceneWarnings(const gs::Scene& scene);

}  // namespace vesta::app
