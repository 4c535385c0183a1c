// SPDX-License-Identifier: Apache-2.0
// Warnings of `vesta doctor` about photographs, points and poses.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/scenes/colmap.h"

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

// Images wider than 640 pixels are first shrunk to that width, so that results are comparable. Throws Error for an
// empty image.
ViewDiagnostics DiagnosticsOf(const gs::Image& image);

// Mean absolute difference of two thumbnails over pixels and channels, 0..1.
double ThumbnailDistance(const ViewDiagnostics& a, const ViewDiagnostics& b);

// One line per warning, the most serious kind first. A kind that affects many views names five of them and the number
// of the others. Warns about few views, few points, views that see few points, views with equal poses, and photographs
// that are nearly identical, of one colour, blurred, of another exposure, or saturated, and about exposures that
// differ. Throws Error if a photograph cannot be read. Good photographs can cause warnings too.
std::vector<std::string> SceneWarnings(const gs::Scene& scene, const gs::PointTracks& tracks = {});

}  // namespace vesta::app
