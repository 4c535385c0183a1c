// SPDX-License-Identifier: Apache-2.0
// Checkpoints of `vesta train`: interval, file name, and a record of the run that wrote them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/settings/train_settings.h"
#include "splatting/train/session/checkpoint.h"
#include "splatting/train/session/training_clock.h"

namespace vesta::app {

// Parses --checkpoint_every or --snapshot_every: "500" means iterations, "10m" means minutes, and an empty text means
// never. Throws UsageError (one line with the flag) for any other text.
gs::Interval ParseInterval(const char* flag, const std::string& text);
// Throws UsageError if one of the two intervals is invalid.
void CheckIntervals(const Flags& flags);

// DIR/checkpoint.vesta.
std::string CheckpointFile(const std::string& folder);

// Record of the run that wrote a checkpoint: scene folder, options, --checkpoint_every, --snapshot_every, and scene
// flags (scene_and_splat.h).
struct Origin {
  std::string scene;
  TrainSettings settings;
  std::string checkpoint_every, snapshot_every;
  std::vector<std::pair<std::string, std::string>> scene_flags;  // SceneFlagTexts
};
// The record as JSON, with the absolute path of the scene.
std::string OriginText(const Origin& origin);
// Throws Error with the file name if the record is incomplete.
Origin ReadOrigin(const gs::Checkpoint& checkpoint);

// Checks that a training with the settings `before` can continue from the checkpoint with the settings `now`. Throws
// Error (one line with the option) if an option differs that must not change during a training. In the LM stage, these
// options include all options of Adam and of densification. Also throws Error if Adam has already done the new number
// of iterations.
void CheckResumable(const gs::Checkpoint& checkpoint, const TrainSettings& before, const TrainSettings& now);

}  // namespace vesta::app
