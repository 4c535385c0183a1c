// SPDX-License-Identifier: Apache-2.0
// What a training refuses before it begins.
#pragma once

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/distributed/process_group.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// Throws Error, one line, where this scene cannot be trained on so: views without their photographs, pixels that are no
// numbers, photographs that have no room where all are needed at once, no views to judge a target by, what
// several processes cannot do. Collective.
void CheckTraining(const Scene& scene, const TrainOptions& options, const StageRunners& stages,
                   const ProcessGroup& processes);

}  // namespace vesta::gs
