// SPDX-License-Identifier: Apache-2.0
// The options of a training from presets, --config files and the command line, and as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/cli/flags.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::app {

// All options, complete: {"adam": {"iterations": ...}, ...}.
nlohmann::ordered_json OptionsJson(const gs::TrainOptions& options);

class ConfigFile {
 public:
  // All functions throw Error: one line with the file and the key.
  explicit ConfigFile(const std::string& path);
  // Parses `text`, the content of the file.
  ConfigFile(const std::string& path, const std::string& text);

  // The text of a key next to "options"; throws if it is missing.
  std::string Text(const char* key) const;
  // The names and texts of an object; empty if it is missing.
  std::vector<std::pair<std::string, std::string>> Texts(const char* key) const;
  // Empty if the file names no preset.
  std::string preset() const;
  // Sets the options that are in the file; it may have any subset.
  void Apply(gs::TrainOptions& options) const;

 private:
  std::string path_;
  nlohmann::ordered_json json_;
};

// The options of a training: the preset, overridden by --config, overridden by flags and --set.
struct TrainSettings {
  std::string preset;  // the preset that the options started from
  gs::TrainOptions options;
};

// The options of a preset for this command. method: for refine and prune.
gs::TrainOptions PresetOf(const CommandInfo& command, const std::string& preset,
                          std::optional<gs::RefineMethod> method = {});

// For train, config, refine and prune. Throws Error if a file cannot be used or options do not fit together. resumed:
// settings of the checkpoint, used instead of the preset unless --preset or --config is given.
TrainSettings SettingsOf(const CommandLine& line, const TrainSettings* resumed = nullptr);

// The options with which a training loads its scene.
gs::LoadSceneOptions SceneOptions(const Flags& flags, const gs::TrainOptions& options);

// Sets the number of threads and checks the device, the first step of every command. Throws as CheckDevice.
void UseComputeFlags(const Flags& flags);

}  // namespace vesta::app
