// Once around what the cameras of a scene look at.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

struct Orbit {
  std::vector<View> views;
  // The widest angle about the axis from which no photograph was taken, degrees.
  double unseen_degrees = 0;
};

// A circle about PointLookedAt, in the plane across UpOf, at the median distance and height of the scene's cameras; it
// looks at the point, and begins at the first camera. frames: at least 1; another would be the first again. Throws
// Error for a scene without views.
Orbit OrbitOf(const Scene& scene, const Camera& camera, int frames);

}  // namespace vesta::gs
