// SPDX-License-Identifier: Apache-2.0
// Scenes at the limits of what a Gaussian, an image and a camera can be, each with what is expected of it.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "tests/support/splat_scenes.h"

namespace vesta::test {

struct ExtremeScene {
  std::string name;
  Scene scene;
  Index seen;              // Gaussians, in any precision
  double tolerance;        // of the image in double, relative to the brightest colour or 1
  double float_tolerance;  // the same in float, and of J v relative to its largest entry
};
inline std::ostream& operator<<(std::ostream& os, const ExtremeScene& extreme) { return os << extreme.name; }

// Four ordinary Gaussians, and those of which the case speaks, before a camera at the origin that looks along z.
std::vector<ExtremeScene> ExtremeGaussians();
// Ordinary Gaussians before images and lenses that are not.
std::vector<ExtremeScene> ExtremeCameras();

// A camera at the origin that looks along z, its principal point in the middle.
splat::PosedCamera AxisView(int width, int height, double focal_length);

}  // namespace vesta::test
