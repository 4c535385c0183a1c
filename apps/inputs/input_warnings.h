// SPDX-License-Identifier: Apache-2.0
// Warnings about a splat that, judging by its quality, probably does not match the scene. One line each; empty: no
// warning.
#pragma once

#include <string>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// Warns about a PSNR so low that the splat does not seem to show this scene. train_psnr: mean over the training views,
// dB.
std::string WarningOfScene(double train_psnr);

// Warns about a training with a very low PSNR at its end: the scene or the options are probably wrong. Names the reason
// if it finds one: photographs of one colour, points that no training view sees, or all points at the same position.
std::string WarningOfTraining(const gs::Scene& scene, double train_psnr);

}  // namespace vesta::app
