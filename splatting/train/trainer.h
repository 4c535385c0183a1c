// SPDX-License-Identifier: Apache-2.0
// Training in two stages: Adam from points, then Levenberg-Marquardt by the engine; or LM alone, from a given model;
// and the splat of a saved training.
#pragma once

#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/train/session/checkpoint.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/session/train_callbacks.h"
#include "splatting/train/session/train_result.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// What the process has spent before the training: seconds since its start (loading), and memory in MiB, the scene's
// included, a model to refine not.
struct BeforeTraining {
  double seconds = 0, mib = 0;
};

// The scene's images must be loaded. With callbacks.resume
// the training goes on with these options, to the same bits as without the break where they are those of before; throws
// Error where the checkpoint is of another scene, or no iterations are asked for beyond those that it has.
TrainResult Train(const Scene& scene, const TrainOptions& options, const BeforeTraining& before,
                  const TrainCallbacks& callbacks, const StageRunners& stages = HostStages());
// From `model`, whose SH degree is kept, and count and order too where none are to be taken out; stages as the options
// have them.
TrainResult Refine(const Scene& scene, SplatModel model, const TrainOptions& options, const BeforeTraining& before,
                   const TrainCallbacks& callbacks, const StageRunners& stages = HostStages());

// The splat that a training had when its state was saved, in the frame of its scene. options: those of the training.
// Throws Error, which names the file, where the state is none of such a training.
SplatModel ModelOfCheckpoint(const Checkpoint& checkpoint, const TrainOptions& options);

}  // namespace vesta::gs
