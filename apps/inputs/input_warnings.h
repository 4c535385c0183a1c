// SPDX-License-Identifier: Apache-2.0
// Warnings about inputs that probably do not match, judged by the quality of the result. Each is one line, or empty.
#pragma once

#include <string>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// Warns if the splat does not seem to show this scene. train_psnr: mean over the training views, in dB.
std::string WarningOfScene(double train_psnr);

// Warns if a training ended with this PSNR because of a wrong scene or wrong options. Names the reason if it finds one:
// photographs of one colour, points that no training view sees, or points that all coincide.
std::string WarningOfTraining(const gs::Scene& scene, double train_psnr);

}  // namespace vesta::app
