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

// Parses "500" (iterations) or "10m" (minutes); empty: never. Throws UsageError with the flag.
gs::Interval ParseInterval(const char* flag, const std::string& text);
// Checks --checkpoint_every and --snapshot_every before the work starts.
void CheckIntervals(const Flags& flags);

// DIR/checkpoint.vesta.
std::string CheckpointFile(const std::string& folder);

// The run that wrote a checkpoint, as recorded in it: the scene folder, the options, the intervals of
// --checkpoint_every and --snapshot_every, and the scene flags.
struct Origin {
  std::string scene;
  TrainSettings settings;
  std::string checkpoint_every, snapshot_every;
  std::vector<std::pair<std::string, std::string>> scene_flags;  // SceneFlagTexts
};
// As JSON text, with an absolute path of the scene.
std::string OriginText(const Origin& origin);
// Throws Error with the file name if the record is incomplete.
Origin ReadOrigin(const gs::Checkpoint& checkpoint);

// Throws Error (one line with the changed option) if a training that started with `before` cannot continue from the
// checkpoint with `now`. Lengths and schedules of the remaining training may change; other options may not.
void CheckResumable(const gs::Checkpoint& checkpoint, const TrainSettings& before, const TrainSettings& now);

}  // namespace vesta::app
