// SPDX-License-Identifier: Apache-2.0
#include "apps/settings/train_settings.h"

#include <optional>

#include "apps/device/device.h"
#include "apps/inputs/posed_model.h"
#include "apps/inputs/scene_flags.h"
#include "apps/settings/config_json.h"
#include "kernels/core/parallel.h"

namespace vesta::app {

gs::TrainOptions PresetOf(const CommandInfo& command, const std::string& preset,
                          std::optional<gs::RefineMethod> method) {
  if (command.command == kRefine) return gs::RefinePresetOptions(preset, method);
  if (command.command == kPrune) return gs::PrunePresetOptions(preset, method);
  return gs::PresetOptions(preset);
}

TrainSettings SettingsOf(const CommandLine& line, const TrainSettings* resumed) {
  const Flags& flags = line.flags;
  std::optional<ConfigFile> file;
  if (!flags.config.empty()) file.emplace(flags.config);
  TrainSettings settings;
  settings.preset = file ? file->preset() : "";
  if (!flags.preset.empty()) settings.preset = flags.preset;
  if (settings.preset.empty()) settings.preset = kDefaultPreset;
  const bool goes_on = resumed && flags.preset.empty() && !file;
  if (goes_on) settings.preset = resumed->preset;
  settings.options = goes_on ? resumed->options : PresetOf(*line.command, settings.preset, flags.method);
  if (file) file->Apply(settings.options);
  for (const GivenOption& given : line.options) given.field->Set(given.value, settings.options);
  if (line.command->command == kRefine) {  // a file may ask for what refining does not do
    settings.options.parsimony = PresetOf(*line.command, settings.preset, flags.method).parsimony;
  }
  if (flags.fixed_model) {
    settings.options.density.enabled = false;
    settings.options.parsimony = gs::ParsimonyOptions::None();
    settings.options.adam.sh_band_every = 0;
  }
  gs::ValidateOptions(settings.options);
  return settings;
}

gs::LoadSceneOptions SceneOptions(const Flags& flags, const gs::TrainOptions& options) {
  gs::LoadSceneOptions scene;
  UseSceneFlags(flags, options.memory.budget_gib, &scene);
  scene.downscale = options.downscale;
  scene.background = ToFloat(options.background);
  scene.low_pass = options.low_pass;
  scene.random_points.seed = options.seed;
  scene.hold_out = options.target_psnr > 0;
  return scene;
}

void UseComputeFlags(const Flags& flags) {
  CheckDevice(flags.device);
  SetNumThreads(flags.threads);
}

}  // namespace vesta::app
