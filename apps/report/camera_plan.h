// SPDX-License-Identifier: Apache-2.0
// Where the cameras of a scene stand, drawn.
#pragma once

#include <span>
#include <string>

#include "apps/report/error_map.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// Two drawings (SVG), from above and from the side, where up is the mean of the cameras' own: training views grey, test
// views from green (the one met best) to red (the worst), each with its name; a sample of the points behind them.
// errors: of the test views, or none.
std::string CameraPlans(const gs::Scene& scene, std::span<const ViewError> errors);

}  // namespace vesta::app
