// SPDX-License-Identifier: Apache-2.0
// Determines the options of a training from presets, --config files and the command line. Writes them as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/cli/flags.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::app {

// Returns all options as JSON: {"adam": {"iterations": ...}, ...}.
nlohmann::ordered_json OptionsJson(const gs::TrainOptions& options);

// A JSON file for --config: {"preset": ..., "options": {...}}, such as metrics.json or the output of `vesta config`.
class ConfigFile {
 public:
  // Reads the file. All functions of the class throw Error (one line with the file and the key) for invalid contents.
  explicit ConfigFile(const std::string& path);
  // For a file that was read before: `text` is its content, `path` appears only in messages.
  ConfigFile(const std::string& path, const std::string& text);

  // The value of a key beside "options", a text; throws if it is missing.
  std::string Text(const char* key) const;
  // The names and values of the object at a key beside "options", as texts; empty if it is missing.
  std::vector<std::pair<std::string, std::string>> Texts(const char* key) const;
  // The name of the preset; empty if the file has none.
  std::string preset() const;
  // Sets the options that are in the file and leaves the others.
  void Apply(gs::TrainOptions& options) const;

 private:
  std::string path_;
  nlohmann::ordered_json json_;
};

// The options of a training. Each comes from the command line (its flag or --set), else from the file of --config, else
// from the preset.
struct TrainSettings {
  std::string preset;  // the name of the preset
  gs::TrainOptions options;
};

// Returns the options of a preset for a command. method: only for refine and prune; empty: as the preset says.
gs::TrainOptions PresetOf(const CommandInfo& command, const std::string& preset,
                          std::optional<gs::RefineMethod> method = {});

// Returns the settings for train, config, refine or prune. resumed: the settings of the checkpoint to resume, or null;
// they replace the preset unless --preset or --config is given. Throws Error if a file cannot be used or options
// contradict each other.
TrainSettings SettingsOf(const CommandLine& line, const TrainSettings* resumed = nullptr);

// The options with which a training loads its scene.
gs::LoadSceneOptions SceneOptions(const Flags& flags, const gs::TrainOptions& options);

// Sets the number of threads from --threads and checks --device; called before every command. Throws as CheckDevice.
void UseComputeFlags(const Flags& flags);

}  // namespace vesta::app
