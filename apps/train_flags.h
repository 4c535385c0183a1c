// From flags to the options of a training run.
#pragma once

#include <array>
#include <string>

#include "problems/gaussian_splatting/train/options.h"

namespace vesta::app {

// These options, a preset's, and over them every flag that was given; background is left to the caller. Throws Error
// where options cannot be used together.
gs::TrainOptions WithTrainFlags(gs::TrainOptions options);

// What the options have for the flag of this name, as it would be written; empty for a flag that stands for none of
// them.
std::string OptionText(const gs::TrainOptions& options, const std::string& flag);

// Colour of --background, 0..1.
std::array<float, 3> BackgroundFromFlag();

// Sets the number of threads and checks the device: what every command does first. Throws Error for --device=cuda.
void UseComputeFlags();

}  // namespace vesta::app
