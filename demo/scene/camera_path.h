// SPDX-License-Identifier: Apache-2.0
// Where the pictures of the demo scene are taken from.
#pragma once

#include <vector>

#include "demo/scene/trace.h"

namespace vesta::demo {

// `count` views of width x height pixels from two rings round the scene, one low, one high, all looking at its middle.
// Directions spread evenly over the full turn; heights alternate, so that the test views, every eighth one, are low and
// high in turn.
std::vector<View> CameraPath(int count, int width, int height);

// `count` views as of somebody who films while walking once round the scene: one after the other along a smooth path,
// on which height, distance and where the camera looks sway.
std::vector<View> Walk(int count, int width, int height);

}  // namespace vesta::demo
