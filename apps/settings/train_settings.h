// SPDX-License-Identifier: Apache-2.0
// The options of a training as a command line and files give them, and as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/cli/flags.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::app {

// Complete: every field of every room.
nlohmann::ordered_json OptionsJson(const gs::TrainOptions& options);

class ConfigFile {
 public:
  // Throws Error, as all of this does: one line that names the file and what of it.
  explicit ConfigFile(const std::string& path);
  // Of a text that stands in the file.
  ConfigFile(const std::string& path, const std::string& text);

  // Of a key beside the options; throws where there is none.
  std::string Text(const char* key) const;
  // The names and texts of an object; none where there is no such object.
  std::vector<std::pair<std::string, std::string>> Texts(const char* key) const;
  // Empty where it names none.
  std::string preset() const;
  // Sets the options that the file has; there may be any of them.
  void Apply(gs::TrainOptions& options) const;

 private:
  std::string path_;
  nlohmann::ordered_json json_;
};

// What a command line makes of the options of training: the preset's, over them those of --config's file, over them
// what was given.
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
