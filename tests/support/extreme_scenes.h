// SPDX-License-Identifier: Apache-2.0
// Scenes with extreme Gaussians, image sizes or cameras, and the expected accuracy of rendering.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "tests/support/splat_scenes.h"

namespace vesta::test {

struct ExtremeScene {
  std::string name;
  Scene scene;
  Index seen;              // visible Gaussians, in float and double
  double tolerance;        // for the image in double, relative to the brightest colour, at least 1
  double float_tolerance;  // in float; also for J v, relative to its largest entry
};
inline std::ostream& operator<<(std::ostream& os, const ExtremeScene& extreme) { return os << extreme.name; }

// Four ordinary Gaussians and one or more extreme ones. The camera at the origin looks along z.
std::vector<ExtremeScene> ExtremeGaussians();
// Ordinary Gaussians and an extreme image size or lens.
std::vector<ExtremeScene> ExtremeCameras();

// At the origin, looking along z, with a centred principal point.
splat::PosedCamera AxisView(int width, int height, double focal_length);

}  // namespace vesta::test
