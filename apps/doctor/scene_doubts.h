// SPDX-License-Identifier: Apache-2.0
// What is odd about a scene, before anything is trained on it.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// A line for each thing, most telling first; of things that many views share, the first few and how many more. Looked
// for: few views, few points, views that see few of the points, photographs of one colour, that are nearly the same as
// another, blurred, or darker or lighter than the others, or burnt out, and views at one place that look one way. The
// images must be there. These are signs, and a photograph that is meant so shows them too.
std::vector<std::string> SceneDoubts(const gs::Scene& scene);

}  // namespace vesta::app
