// What a training refuses before it begins.
#pragma once

#include "problems/gaussian_splatting/distributed/process_group.h"
#include "problems/gaussian_splatting/model/scene.h"
#include "problems/gaussian_splatting/train/options.h"
#include "problems/gaussian_splatting/train/stage_runners.h"

namespace vesta::gs {

// Throws Error, one line, where this scene cannot be trained on so: views without their photographs, pixels that are no
// numbers, photographs that have no room where all are needed at once, no views to judge a target by, what
// several processes cannot do. Collective.
void CheckTraining(const Scene& scene, const TrainOptions& options, const StageRunners& stages,
                   const ProcessGroup& processes);

}  // namespace vesta::gs
