// SPDX-License-Identifier: Apache-2.0
// Doubts about what was given, where results are so bad, or so good, that it can hardly have been meant. A line each,
// or nothing.
#pragma once

#include <string>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// Whether splat and scene belong together. train_psnr: mean of the training views, dB.
std::string WarningOfScene(double train_psnr);

// Whether the scene, or the options, of a training that ended so were what was meant; with the reason, where it is
// seen: photographs of one colour, points that no training view sees, or that are all one.
std::string WarningOfTraining(const gs::Scene& scene, double train_psnr);

}  // namespace vesta::app
