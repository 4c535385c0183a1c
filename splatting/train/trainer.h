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

// Resources used before the training: seconds since the start of the process, and memory in MiB, including the scene
// but not a model to refine.
struct BeforeTraining {
  double seconds = 0, mib = 0;
};

// Trains a scene whose images are loaded. With callbacks.resume the training continues from a checkpoint; with
// unchanged options the result is bit-identical to an uninterrupted run. Throws Error if the checkpoint belongs to
// another scene, or if no iterations remain.
TrainResult Train(const Scene& scene, const TrainOptions& options, const BeforeTraining& before,
                  const TrainCallbacks& callbacks, const StageRunners& stages = HostStages());
// Refines `model`; the options select the stages. The SH degree is kept; without pruning, so are the count and order of
// the Gaussians.
TrainResult Refine(const Scene& scene, SplatModel model, const TrainOptions& options, const BeforeTraining& before,
                   const TrainCallbacks& callbacks, const StageRunners& stages = HostStages());

// The model of a checkpoint, in the frame of its scene. options: the options of that training. Throws Error, which
// names the file, if the state does not belong to such a training.
SplatModel ModelOfCheckpoint(const Checkpoint& checkpoint, const TrainOptions& options);

}  // namespace vesta::gs
