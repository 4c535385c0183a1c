// SPDX-License-Identifier: Apache-2.0
// What a command line makes of the options of training: the preset's, over them those of --config's file, over them
// what was given.
#pragma once

#include <string>

#include "apps/cli/flags.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::app {

struct TrainSettings {
  std::string preset;  // where the options started
  gs::TrainOptions options;
};

// Where the options of such a command start. method: of refine and prune.
gs::TrainOptions PresetOf(const CommandInfo& command, const std::string& preset,
                          std::optional<gs::RefineMethod> method = {});

// Of train, config, refine or prune. Throws Error where a file cannot be used, or options do not go together. resumed:
// what stands in the place of the preset where none is given.
TrainSettings SettingsOf(const CommandLine& line, const TrainSettings* resumed = nullptr);

// How such a training loads its scene.
gs::LoadSceneOptions SceneOptions(const Flags& flags, const gs::TrainOptions& options);

// Sets the number of threads and checks the device: what every command does first. Throws Error for --device=cuda.
void UseComputeFlags(const Flags& flags);

}  // namespace vesta::app
