// SPDX-License-Identifier: Apache-2.0
// Scenes with extreme Gaussians, image sizes or cameras, and the accuracy to expect from rendering them.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "tests/support/splat_scenes.h"

namespace vesta::test {

struct ExtremeScene {
  std::string name;
  Scene scene;
  Index seen;              // expected number of visible Gaussians, in float and double
  double tolerance;        // bound for errors of the image in double, relative to the brightest colour, at least 1
  double float_tolerance;  // the same in float; also for errors of J v, relative to its largest entry
};
inline std::ostream& operator<<(std::ostream& os, const ExtremeScene& extreme) { return os << extreme.name; }

// Scenes with four ordinary Gaussians and one or more extreme ones. The camera is at the origin and looks along z.
std::vector<ExtremeScene> ExtremeGaussians();
// Scenes with ordinary Gaussians and an extreme image size or lens.
std::vector<ExtremeScene> ExtremeCameras();

// A camera at the origin that looks along z, with the principal point in the centre.
splat::PosedCamera AxisView(int width, int height, double focal_length);

}  // namespace vesta::test
