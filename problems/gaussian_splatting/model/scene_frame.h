// SPDX-License-Identifier: Apache-2.0
// Where a scene lies in the world of its files. Positions of points and Gaussians are floats, which far from their
// origin are coarse: a georeferenced scene is trained about an origin of its own.
#pragma once

#include <array>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Points as files have them.
struct WorldPoints {
  std::vector<std::array<double, 3>> positions;  // at least one, within the range of float
  std::vector<std::array<float, 3>> colors;      // r, g, b in 0..1; as many
};

// Gives the scene, whose views are as in the files, its points and its extent. Where the middle of the points (the
// median of each coordinate) is farther from the origin than 100 times their size (the median distance from it, by the
// largest coordinate; of the cameras where the points are all one), it becomes the origin: Scene::origin, and the views
// follow. Nearer, a float has five digits of the size left, and everything stays as it is.
void PlaceInScene(const WorldPoints& points, Scene* scene);

// A model of any frame brought into that of the scene, and one of the scene's brought into the world's. There it stays
// about the scene's origin, which SplatModel::origin then tells, where floats could not hold it: where that is farther
// from the world's than 1000 times the extent.
void MoveToScene(const Scene& scene, SplatModel* model);
void MoveToWorld(const Scene& scene, SplatModel* model);

// The same of a view: from the world of the files into the scene's frame, and back.
void MoveToScene(const Scene& scene, View* view);
void MoveToWorld(const Scene& scene, View* view);

}  // namespace vesta::gs
