// SPDX-License-Identifier: Apache-2.0
// The cameras that a training has found, beside its splat.
#pragma once

#include <string>

#include "apps/cli/outputs.h"
#include "splatting/train/session/train_result.h"

namespace vesta::app {

// Of the output's folder.
inline constexpr const char* kCameraFolder = "cameras";

// Those of an earlier training.
void RemoveCameras(const OutputFolder& out);

// What was found of the cameras, as a COLMAP model with the scene's points. Returns a line that says so; none where
// nothing moved: then nothing is written.
std::string SaveCameras(const gs::Scene& scene, const gs::TrainResult& result, const OutputFolder& out);

}  // namespace vesta::app
