// SPDX-License-Identifier: Apache-2.0
// Training in two stages, Adam and then Levenberg-Marquardt; refinement of a given model; and the model of a
// checkpoint.
#pragma once

#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/train/session/checkpoint.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/session/train_callbacks.h"
#include "splatting/train/session/train_result.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// Resources used before the training: seconds since the start of the process, and memory of the process in MiB. The
// memory includes the scene, but not the model that Refine receives.
struct BeforeTraining {
  double seconds = 0, mib = 0;
};

// Trains a scene, whose photographs must be in memory or in its store. With callbacks.resume the training continues
// from a checkpoint; if the options are unchanged, the result is bit-identical to an uninterrupted run. Throws Error if
// the checkpoint belongs to another scene, or if no iterations remain.
TrainResult Train(const Scene& scene, const TrainOptions& options, const BeforeTraining& before,
                  const TrainCallbacks& callbacks, const StageRunners& stages = HostStages());
// Trains the given model further, without densification; the options select the stages. The SH degree stays the same.
// Without pruning, so do the number and order of the Gaussians.
TrainResult Refine(const Scene& scene, SplatModel model, const TrainOptions& options, const BeforeTraining& before,
                   const TrainCallbacks& callbacks, const StageRunners& stages = HostStages());

// Returns the model in a checkpoint, in the coordinates of its scene. options: the options of the training that wrote
// it. Throws Error with the file's name if the state does not fit these options.
SplatModel ModelOfCheckpoint(const Checkpoint& checkpoint, const TrainOptions& options);

}  // namespace vesta::gs
