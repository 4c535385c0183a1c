// SPDX-License-Identifier: Apache-2.0
// What a page has to know of a scene to move through it.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// "pivot" (what to turn about: the middle of the points, else of the Gaussians), "radius" (half of them are within),
// "up" (a unit vector: that of the cameras), all in the scene's frame, and "views": for each of the scene's, in their
// order, "name", "role" (train, held_out or test), "width", "height", "position", "rotation" (w,x,y,z; camera to world)
// and "focal" in heights of the picture. views: the scene's, where their cameras stand.
std::string SceneJson(const gs::Scene& scene, const std::vector<gs::View>& views, const gs::SplatModel& model);

// The half of the model's extent, for a scene that is nothing but a splat: its near plane follows from it.
double ExtentOf(const gs::SplatModel& model);

}  // namespace vesta::app
