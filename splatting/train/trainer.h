// SPDX-License-Identifier: Apache-2.0
// Training in two stages, Adam and then Levenberg-Marquardt; refinement; and the model of a checkpoint.
#pragma once

#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/train/session/checkpoint.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/session/train_callbacks.h"
#include "splatting/train/session/train_result.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// Used before the training: seconds since the start of the process, and its memory in MiB with the scene, but without
// the model that Refine receives.
struct BeforeTraining {
  double seconds = 0, mib = 0;
};

// The Gaussians with which Train starts: one per point of the scene, in spatial order. options: from FitToScene.
SplatModel InitialModel(const Scene& scene, const TrainOptions& options);

// Photographs must be in memory or in the scene's store. With callbacks.resume the training continues from a
// checkpoint; with unchanged options, the result is bit-identical to an uninterrupted run. Throws Error if the
// checkpoint belongs to another scene, or if no iterations remain.
TrainResult Train(const Scene& scene, const TrainOptions& options, const BeforeTraining& before,
                  const TrainCallbacks& callbacks, const StageRunners& stages = HostStages());
// Trains the given model further, without densification; the options select the stages. The SH degree stays the same.
// Without pruning, the number and the order of the Gaussians stay the same too.
TrainResult Refine(const Scene& scene, SplatModel model, const TrainOptions& options, const BeforeTraining& before,
                   const TrainCallbacks& callbacks, const StageRunners& stages = HostStages());

// The model has the coordinates of its scene. options: of the training that wrote the checkpoint. Throws Error with the
// file's name if the state does not fit the options.
SplatModel ModelOfCheckpoint(const Checkpoint& checkpoint, const TrainOptions& options);

}  // namespace vesta::gs
