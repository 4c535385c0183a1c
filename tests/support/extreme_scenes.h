// SPDX-License-Identifier: Apache-2.0
// Scenes with extreme Gaussians, images and cameras, and the expected accuracy.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "tests/support/splat_scenes.h"

namespace vesta::test {

struct ExtremeScene {
  std::string name;
  Scene scene;
  Index seen;              // number of visible Gaussians, in any precision
  double tolerance;        // of the image in double, relative to the brightest colour or 1
  double float_tolerance;  // the same in float, and of J v relative to its largest entry
};
inline std::ostream& operator<<(std::ostream& os, const ExtremeScene& extreme) { return os << extreme.name; }

// Four ordinary Gaussians and the extreme ones of the case. The camera is at the origin and looks along z.
std::vector<ExtremeScene> ExtremeGaussians();
// Ordinary Gaussians with extreme images and lenses.
std::vector<ExtremeScene> ExtremeCameras();

// A camera at the origin that looks along z, with the principal point in the centre.
splat::PosedCamera AxisView(int width, int height, double focal_length);

}  // namespace vesta::test
