// SPDX-License-Identifier: Apache-2.0
// Reads the options of a training from presets, --config files and the command line, and writes them as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/cli/flags.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::app {

// {"adam": {"iterations": ...}, ...}.
nlohmann::ordered_json OptionsJson(const gs::TrainOptions& options);

// A JSON file for --config: {"preset": ..., "options": {...}}, such as metrics.json or the output of `vesta config`.
class ConfigFile {
 public:
  // All functions throw Error (one line with the file and the key) for invalid contents.
  explicit ConfigFile(const std::string& path);
  // For a file read before: `text` is its content, `path` only for messages.
  ConfigFile(const std::string& path, const std::string& text);

  // A text beside "options"; throws if it is missing.
  std::string Text(const char* key) const;
  // Names and values of an object beside "options", as texts; empty if it is missing.
  std::vector<std::pair<std::string, std::string>> Texts(const char* key) const;
  // The preset; empty if the file has none.
  std::string preset() const;
  // Sets the options in the file and leaves the others.
  void Apply(gs::TrainOptions& options) const;

 private:
  std::string path_;
  nlohmann::ordered_json json_;
};

// Each option comes from the command line (its flag or --set), else from the file of --config, else from the preset.
struct TrainSettings {
  std::string preset;  // its name
  gs::TrainOptions options;
};

// Options of a preset for a command. method: only for refine and prune; empty: as the preset says.
gs::TrainOptions PresetOf(const CommandInfo& command, const std::string& preset,
                          std::optional<gs::RefineMethod> method = {});

// The settings for train, config, refine or prune. resumed: settings of the checkpoint to resume, or null. They replace
// the preset unless --preset or --config is given. Throws Error if a file cannot be used or options contradict each
// other.
TrainSettings SettingsOf(const CommandLine& line, const TrainSettings* resumed = nullptr);

// The options with which a training loads its scene.
gs::LoadSceneOptions SceneOptions(const Flags& flags, const gs::TrainOptions& options);

// Sets the number of threads and checks --device. Call it before every command. Throws as CheckDevice.
void UseComputeFlags(const Flags& flags);

}  // namespace vesta::app
