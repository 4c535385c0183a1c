// SPDX-License-Identifier: Apache-2.0
// Random initial points for scenes without points.
#pragma once

#include <cstdint>
#include <vector>

#include "problems/gaussian_splatting/model/scene_frame.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

struct RandomPoints {
  Index count = 10000;
  std::uint64_t seed = 0;
};

// Random colours, and positions uniform in the cube [-1.3, 1.3]^3 (as Kerbl et al. 2023 for Blender scenes).
WorldPoints PointsInCube(const RandomPoints& random);

// Random points with random colours in the training views, equally many per view and uniform over the image. Depths are
// uniform in the logarithm, from a third to three times the depth of the point closest to all optical axes. If the axes
// are nearly parallel or meet behind a camera, four times the radius of the cameras about their mean replaces that
// depth. If all cameras are at one place, it is 1. Throws Error if the points exceed the range of float.
WorldPoints PointsInViews(const std::vector<View>& views, const RandomPoints& random);

}  // namespace vesta::gs
