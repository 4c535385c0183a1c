// SPDX-License-Identifier: Apache-2.0
// Warnings about a splat and a scene that probably do not match, judged by the quality of the result. Each function
// returns one line; empty: no warning.
#pragma once

#include <string>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// Warns if the PSNR is so low that the splat does not seem to show this scene. train_psnr: mean over the training
// views, in dB.
std::string WarningOfScene(double train_psnr);

// Warns if a training ended with a very low PSNR, probably because of a wrong scene or wrong options. Names the reason
// if it finds one: photographs of one colour, points that no training view sees, or points that all have the same
// position.
std::string WarningOfTraining(const gs::Scene& scene, double train_psnr);

}  // namespace vesta::app
