// SPDX-License-Identifier: Apache-2.0
// The local frame of a scene. Positions of points and Gaussians are floats, which are coarse far from the origin. A
// georeferenced scene is therefore trained about a local origin.
#pragma once

#include <array>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Points as read from files.
struct WorldPoints {
  std::vector<std::array<double, 3>> positions;  // at least one, within the range of float
  std::vector<std::array<float, 3>> colors;      // r, g, b in 0..1; one per position
};

// Sets the points and the extent of the scene, whose views are in the frame of the files. The centre of the points is
// the median of each coordinate. Their size is the median distance from it, by the largest coordinate; if all points
// coincide, of the camera centres. If the centre is farther from the origin than 100 times the size, a point near it
// becomes Scene::origin, and the views are moved accordingly. Otherwise nothing moves: floats then resolve the size to
// five digits.
void PlaceInScene(const WorldPoints& points, Scene* scene);

// Moves a model from any frame to the scene's frame, or from there to the world. If the scene's origin is more than
// 1000 extents from the world's, floats could not represent the result. The model then keeps the scene's origin, in
// SplatModel::origin.
void MoveToScene(const Scene& scene, SplatModel* model);
void MoveToWorld(const Scene& scene, SplatModel* model);

// The same for a view, between the world of the files and the scene's frame.
void MoveToScene(const Scene& scene, View* view);
void MoveToWorld(const Scene& scene, View* view);

}  // namespace vesta::gs
