// A path for cameras that face one way, which stays among them (as in Mildenhall et al. 2019, "Local light field
// fusion").
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Two turns across the mean of the views while the camera goes forward and back once, as far along each axis as nine
// tenths of the scene's cameras; it looks at the point at the median depth. frames: at least 1; another would be the
// first again. Throws Error for a scene without views, or one whose views face different ways.
std::vector<View> SpiralOf(const Scene& scene, const Camera& camera, int frames);

}  // namespace vesta::gs
