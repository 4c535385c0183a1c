// From flags to the options of a training run.
#pragma once

#include <array>

#include "problems/gaussian_splatting/train/options.h"

namespace vesta::app {

// These options, a preset's, and over them every flag that was given; background is left to the caller. Throws Error
// where options cannot be used together.
gs::TrainOptions WithTrainFlags(gs::TrainOptions options);

// Colour of --background, 0..1.
std::array<float, 3> BackgroundFromFlag();

// Sets the number of threads and checks the device: what every command does first. Throws Error for --device=cuda.
void UseComputeFlags();

}  // namespace vesta::app
