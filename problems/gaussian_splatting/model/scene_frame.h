// SPDX-License-Identifier: Apache-2.0
// The frame of a scene. Positions are floats, which are coarse far from the origin. If coordinates are large, as in
// georeferenced scenes, the origin is moved near the points. Here, "world" is the frame of the files.
#pragma once

#include <array>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Points from files.
struct WorldPoints {
  std::vector<std::array<double, 3>> positions;  // at least one, within the range of float
  std::vector<std::array<float, 3>> colors;      // r, g, b in 0..1; one per position
};

// Sets the origin, the points and the extent of the scene, whose views are in the world frame on input. The centre of
// the points is the median of each coordinate. Their size is the median distance from the centre (a distance is the
// largest coordinate difference); if that is 0, the median distance of the camera centres. If the centre is farther
// from the world's origin than 100 times the size, a point near the centre becomes Scene::origin, and the views are
// moved to the new frame. Otherwise the origin stays 0: floats then resolve the size to five digits.
void PlaceInScene(const WorldPoints& points, Scene* scene);

// MoveToScene moves a model to the scene's frame, from the frame given by SplatModel::origin. MoveToWorld moves it from
// the scene's frame to the world and sets SplatModel::origin to 0. If the scene's origin is more than 1000 extents from
// the world's, floats could not represent the positions: the model then stays in the scene's frame, and
// SplatModel::origin is the scene's origin.
void MoveToScene(const Scene& scene, SplatModel* model);
void MoveToWorld(const Scene& scene, SplatModel* model);

// Move a view from the world to the scene's frame, and back.
void MoveToScene(const Scene& scene, View* view);
void MoveToWorld(const Scene& scene, View* view);

}  // namespace vesta::gs
