// SPDX-License-Identifier: Apache-2.0
// Camera paths for the images of the demo scene.
#pragma once

#include <vector>

#include "demo/scene/trace.h"

namespace vesta::demo {

// `count` views of width x height pixels from a low and a high ring around the scene, all looking at its centre. The
// directions are evenly spaced over 360 degrees. Heights alternate such that the test views, every eighth view, are low
// and high in turn.
std::vector<View> CameraPath(int count, int width, int height);

// `count` views as filmed by a person walking once around the scene: consecutive views along a smooth
// path, on which height, distance and viewing direction sway.
std::vector<View> Walk(int count, int width, int height);

}  // namespace vesta::demo
