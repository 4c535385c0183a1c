// SPDX-License-Identifier: Apache-2.0
// Random points for the initial Gaussians of scenes without points.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/model/scene_frame.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

struct RandomPoints {
  Index count = 10000;
  std::uint64_t seed = 0;
};

// Random colours, and positions uniform in [-1.3, 1.3]^3 (as Kerbl et al. 2023 for Blender scenes).
WorldPoints PointsInCube(const RandomPoints& random);

// Random colours and positions in the training views, equally many per view and uniform over the image. The logarithm
// of a point's depth is uniform between log(d / 3) and log(3 d), where d is the likely depth of its view: the depth of
// the point closest to all optical axes. If the axes are nearly parallel or meet behind a camera, d is four times the
// largest distance of a camera from the mean of all cameras; if all cameras are at one place, d is 1. Throws Error if a
// coordinate exceeds the range of float.
WorldPoints PointsInViews(const std::vector<View>& views, const RandomPoints& random);

// Random points for the views of a scene without points, and a note. If all training cameras are outside the cube and
// their optical axes pass through it, the scene is taken for an object in the cube, and the points are from
// PointsInCube; otherwise they are from PointsInViews. source: the file or folder without points, for the note.
WorldPoints PointsForCameras(const std::string& source, const RandomPoints& random, Scene* scene);

}  // namespace vesta::gs
