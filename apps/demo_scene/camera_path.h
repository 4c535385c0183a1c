// Where the pictures of the demo scene are taken from.
#pragma once

#include <vector>

#include "apps/demo_scene/trace.h"

namespace vesta::demo {

// `count` views of width x height pixels from two rings round the scene, one low, one high, all looking at its middle.
// Directions spread evenly over the full turn; heights alternate, and every eighth view, which is one to test with, is
// in turn a low and a high one.
std::vector<View> CameraPath(int count, int width, int height);

}  // namespace vesta::demo
