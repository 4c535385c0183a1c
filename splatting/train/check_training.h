// SPDX-License-Identifier: Apache-2.0
// Checks of the scene and options before a training.
#pragma once

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/distributed/process_group.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// Throws Error if this scene cannot be trained with these options: views without photographs, pixels that are not
// finite, an eps2d that differs from the cameras', too little memory for photographs, no held-out views for a target
// PSNR, or options that camera refinement or several processes do not support. Collective.
void CheckTraining(const Scene& scene, const TrainOptions& options, const StageRunners& stages,
                   const ProcessGroup& processes);

}  // namespace vesta::gs
