// What was found of a lens as the camera of the photographs in their files.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/cameras/view_unknowns.h"
#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::gs {

// The kinds of bent cameras are not closed under LensChange: what was found is met nearly.
struct BentFit {
  BentCamera camera;
  double most_pixels = 0;  // that something is seen beside where it was found to be, of the photograph's file
};

// pinhole: as given, for which photographs of the bent camera were undistorted. The camera of the same kind, with focal
// lengths, principal point and coefficients (of no fisheye k1 to k3, p1 and p2, of a fisheye k1 to k4), that sees what
// was found, by least squares over what the pinhole shows: to hundredths of a pixel, but for a fisheye whose principal
// point was found elsewhere, which has no tangential coefficients. By no change it keeps every bit.
BentFit FitBent(const BentCamera& bent, const Camera& pinhole, const LensChange& found);

// Gives the scene's views (MovedViews) the bent cameras that they have as found, where photographs were undistorted.
// The most of most_pixels.
double BendAsFound(const Scene& scene, const std::vector<ViewUnknowns>& found, std::vector<View>* views);

}  // namespace vesta::gs
