// SPDX-License-Identifier: Apache-2.0
// Camera paths for the images of the demo scene.
#pragma once

#include <vector>

#include "demo/scene/trace.h"

namespace vesta::demo {

// `count` views of width x height pixels, evenly spaced over 360 degrees around the scene, towards its centre. The
// cameras are on a low and a high ring; they alternate such that the test views, every eighth view, are low and high in
// turn.
std::vector<View> CameraPath(int count, int width, int height);

// `count` views along a smooth path once around the scene, as filmed by a walking person: height, distance and viewing
// direction vary smoothly.
std::vector<View> Walk(int count, int width, int height);

}  // namespace vesta::demo
