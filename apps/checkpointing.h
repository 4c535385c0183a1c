// Checkpoints of `vesta train`: how often, where, and what they say of the run that wrote them.
#pragma once

#include <string>

#include "apps/train_settings.h"
#include "problems/gaussian_splatting/train/trainer.h"

namespace vesta::app {

// "500": iterations; "10m": minutes. Empty: never. Throws UsageError naming the flag.
gs::Interval ParseInterval(const char* flag, const std::string& text);

// DIR/checkpoint.vesta.
std::string CheckpointFile(const std::string& folder);

// What a checkpoint keeps for the program: the scene's folder, as an absolute path, and the options.
std::string OriginOf(const std::string& scene, const TrainSettings& settings);

// The run that wrote a checkpoint. Throws Error naming its file where that does not say.
struct Origin {
  std::string scene;
  TrainSettings settings;
};
Origin ReadOrigin(const gs::Checkpoint& checkpoint);

// Throws Error, one line naming what was changed, unless a training with the options of `before` can go on with these
// from where the checkpoint is: lengths and rules of what is still to come may change, the rest may not.
void CheckResumable(const gs::Checkpoint& checkpoint, const gs::TrainOptions& before, const gs::TrainOptions& now);

}  // namespace vesta::app
