// SPDX-License-Identifier: Apache-2.0
// Points for scenes that have none.
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

// Of random colour, uniform in the cube [-1.3, 1.3]^3 about the origin (as Kerbl et al. 2023 for Blender scenes).
WorldPoints PointsInCube(const RandomPoints& random);

// Of random colour, within what the training views see: as many in each, uniform over the image, their depths
// uniform in the logarithm about that at which the view passes what all look at: the point nearest to all optical axes,
// from a third of that depth to three times. Where the axes are about parallel, or meet behind the cameras, that depth
// is four times the radius of the cameras about their mean (1 where all are in one place). Throws Error where floats
// cannot hold that.
WorldPoints PointsInViews(const std::vector<View>& views, const RandomPoints& random);

}  // namespace vesta::gs
