// SPDX-License-Identifier: Apache-2.0
// What a training does on the way: the progress line, checkpoints, snapshots and the page of --view.
#pragma once

#include <memory>

#include "apps/cli/flags.h"
#include "apps/cli/outputs.h"
#include "apps/cli/progress.h"
#include "apps/viewer/training_view.h"
#include "splatting/train/session/train_callbacks.h"

namespace vesta::app {

// Shows the training on the line, and the log where --log_lm asks for it; an interrupt stops it. has_lm: whether LM
// follows the Adam stage, which alone is foretold.
gs::TrainCallbacks CallbacksShownOn(ProgressLine* line, bool has_lm, bool log_lm);

// What --checkpoint_every and --snapshot_every ask for. scene, out: must outlive the training.
void SaveOnTheWay(const Flags& flags, const gs::Scene& scene, const gs::TrainOptions& options, const OutputFolder& out,
                  gs::TrainCallbacks* callbacks);

// Serves the page of --view from here on, of a training that its monitor is to follow; null where it is not asked for.
// scene: must outlive the page.
std::unique_ptr<TrainingView> ViewOfTraining(const Flags& flags, const gs::Scene& scene,
                                             const gs::TrainOptions& options);

}  // namespace vesta::app
