// SPDX-License-Identifier: Apache-2.0
// Checkpoints of `vesta train`: how often, where, and what they say of the run that wrote them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/settings/train_settings.h"
#include "splatting/train/session/checkpoint.h"
#include "splatting/train/session/training_clock.h"

namespace vesta::app {

// "500": iterations; "10m": minutes. Empty: never. Throws UsageError naming the flag.
gs::Interval ParseInterval(const char* flag, const std::string& text);
// The same of --checkpoint_every and --snapshot_every, before there is any work.
void CheckIntervals(const Flags& flags);

// DIR/checkpoint.vesta.
std::string CheckpointFile(const std::string& folder);

// The run that writes a checkpoint, as the checkpoint keeps it: the folder of its scene, its options, how often it
// saves
// (--checkpoint_every, --snapshot_every), and how it reads its scene.
struct Origin {
  std::string scene;
  TrainSettings settings;
  std::string checkpoint_every, snapshot_every;
  std::vector<std::pair<std::string, std::string>> scene_flags;  // SceneFlagTexts
};
// The scene as an absolute path.
std::string OriginText(const Origin& origin);
// Throws Error naming the checkpoint's file where it does not say.
Origin ReadOrigin(const gs::Checkpoint& checkpoint);

// Throws Error, one line naming what was changed, unless a training with the settings of `before` can go on with these
// from where the checkpoint is: lengths and rules of what is still to come may change, the rest may not.
void CheckResumable(const gs::Checkpoint& checkpoint, const TrainSettings& before, const TrainSettings& now);

}  // namespace vesta::app
