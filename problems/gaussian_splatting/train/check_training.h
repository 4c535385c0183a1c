// What a training refuses before it begins.
#pragma once

#include "problems/gaussian_splatting/train/trainer.h"

namespace vesta::gs {

// Throws Error, one line, where this scene cannot be trained on so: views without their photographs, pixels that are no
// numbers, photographs that have no room where all are needed at once, no views to judge a target by, processes that
// do not fit together. Called by all of several processes.
void CheckTraining(const Scene& scene, const TrainOptions& options, const StageRunners& stages, Ranks* ranks);

}  // namespace vesta::gs
