// SPDX-License-Identifier: Apache-2.0
// The splat that a training had come to when its state was saved.
#pragma once

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/train/session/checkpoint.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {

// In the frame of its scene. options: those of the training. Throws Error, which names the file, where the state is
// none of such a training.
SplatModel ModelOfCheckpoint(const Checkpoint& checkpoint, const TrainOptions& options);

}  // namespace vesta::gs
