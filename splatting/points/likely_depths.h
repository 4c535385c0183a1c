// SPDX-License-Identifier: Apache-2.0
// Depths at which a scene without points probably has surfaces, from the cameras alone.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// A likely depth for each view, > 0, world units: the depth of the point closest to all optical axes. If the axes are
// nearly parallel or meet behind a camera, it is four times the largest distance of a camera from the mean of all
// cameras; if all cameras are at one place, it is 1.
std::vector<double> LikelyDepths(const std::vector<View>& views);

}  // namespace vesta::gs
