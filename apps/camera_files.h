// The cameras that a training has found, beside its splat.
#pragma once

#include <string>

#include "apps/outputs.h"
#include "problems/gaussian_splatting/train/trainer.h"

namespace vesta::app {

// Of the output's folder.
inline constexpr const char* kCameraFolder = "cameras";

// What was found of the cameras, as a COLMAP model with the scene's points. Returns a line that says so; none where
// nothing moved: then those of an earlier training go.
std::string SaveCameras(const gs::Scene& scene, const gs::TrainResult& result, const OutputFolder& out);

}  // namespace vesta::app
