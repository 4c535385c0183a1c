// SPDX-License-Identifier: Apache-2.0
#include "apps/settings/train_settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>

#include "apps/device/device.h"
#include "apps/inputs/scene_and_splat.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"

namespace vesta::app {
namespace {

using Json = nlohmann::ordered_json;
using schema::Kind;

// The value of a field, given as text, as JSON.
Json ToJson(const schema::FieldInfo& field, const std::string& text) {
  if (field.kind == Kind::kChoice || field.kind == Kind::kWords || (field.may_be_auto && text == "auto")) return text;
  return Json::parse(field.kind == Kind::kColor ? "[" + text + "]" : text);
}

// The inverse; nothing if the JSON type does not fit.
std::optional<std::string> ToText(const schema::FieldInfo& field, const Json& json) {
  if (field.may_be_auto && json == "auto") return "auto";
  switch (field.kind) {
    case Kind::kWhole:
    case Kind::kNumber:
      return json.is_number() ? std::optional(json.dump()) : std::nullopt;
    case Kind::kSwitch:
      return json.is_boolean() ? std::optional(json.dump()) : std::nullopt;
    case Kind::kColor: {
      if (!json.is_array()) return std::nullopt;
      std::vector<std::string> channels;
      for (const Json& channel : json) channels.push_back(channel.is_number() ? channel.dump() : "");
      return fmt::format("{}", fmt::join(channels, ","));
    }
    case Kind::kChoice:
    case Kind::kWords:
      break;
  }
  return json.is_string() ? std::optional(json.get<std::string>()) : std::nullopt;
}

std::string Shown(const Json& json) { return Printable(json.dump(-1, ' ', true, Json::error_handler_t::replace)); }

// The last key before this byte of the text, as `, after "KEY"`.
std::string AfterWhichKey(const std::string& text, std::size_t byte) {
  const std::size_t colon = text.rfind("\":", byte);
  const std::size_t quote = colon == std::string::npos || colon == 0 ? colon : text.rfind('"', colon - 1);
  if (colon == std::string::npos || quote == std::string::npos) return "";
  return fmt::format(", after {}", Printable(text.substr(quote, colon + 1 - quote)));
}

}  // namespace

Json OptionsJson(const gs::TrainOptions& options) {
  Json json;
  for (const schema::Field<gs::TrainOptions>& field : gs::TrainFields()) {
    const std::size_t dot = field.name.find('.');
    json[field.name.substr(0, dot)][field.name.substr(dot + 1)] = ToJson(field, field.Text(options));
  }
  return json;
}

ConfigFile::ConfigFile(const std::string& path) : ConfigFile(path, ReadFile(path)) {}

ConfigFile::ConfigFile(const std::string& path, const std::string& text) : path_(path) {
  try {
    json_ = Json::parse(text);
  } catch (const Json::parse_error& error) {
    Fail(kBadFile, "{}: invalid JSON at byte {}{}: unexpected or missing value, bracket or end of file", path,
         error.byte, AfterWhichKey(text, error.byte));
  } catch (const Json::out_of_range&) {
    Fail(kBadFile, "{}: a number is too large; correct it", path);
  }
  if (!json_.is_object() || !json_.contains("options") || !json_["options"].is_object()) {
    Fail(kBadFile, "{}: it has no \"options\"; give the metrics.json of a training or the output of `vesta config`",
         path);
  }
}

std::string ConfigFile::Text(const char* key) const {
  if (!json_.contains(key) || !json_[key].is_string())
    Fail(kBadFile, "{}: the key {} is missing or is not a text", path_, key);
  return json_[key].get<std::string>();
}

std::vector<std::pair<std::string, std::string>> ConfigFile::Texts(const char* key) const {
  std::vector<std::pair<std::string, std::string>> texts;
  if (!json_.contains(key)) return texts;
  if (!json_[key].is_object()) Fail(kBadFile, "{}: {} is not an object", path_, key);
  for (const auto& [name, value] : json_[key].items()) {
    if (!value.is_string()) Fail(kBadFile, "{}: {}.{} is not a text", path_, key, Printable(name));
    texts.emplace_back(name, value.get<std::string>());
  }
  return texts;
}

std::string ConfigFile::preset() const {
  if (!json_.contains("preset")) return "";
  std::vector<std::string> names;
  for (const gs::Preset& preset : gs::Presets()) {
    names.emplace_back(preset.name);
    if (json_["preset"] == preset.name) return preset.name;
  }
  Fail(kBadFile, "{}: preset={}: it must be one of {}", path_, Shown(json_["preset"]), fmt::join(names, ", "));
}

void ConfigFile::Apply(gs::TrainOptions& options) const {
  for (const auto& [room, values] : json_["options"].items()) {
    if (!values.is_object())
      Fail(kBadFile, "{}: {}: it must be an object with options, in braces", path_, Printable(room));
    for (const auto& [key, value] : values.items()) {
      const std::string name = fmt::format("{}.{}", room, key);
      const schema::Field<gs::TrainOptions>* field = schema::Find(gs::TrainFields(), name);
      if (!field) {
        if (const auto renamed = gs::RenamedOptions().find(name); renamed != gs::RenamedOptions().end()) {
          Fail(kBadFile, "{}: {}: this option is now called {}", path_, name, renamed->second);
        }
        const std::vector<std::string> nearest = schema::Nearest(name, schema::Names(gs::TrainFields()));
        Fail(kBadFile, "{}: {}: no such option; {}`vesta config` prints all", path_, Printable(name),
             nearest.empty() ? "" : fmt::format("nearest: {}; ", fmt::join(nearest, ", ")));
      }
      const std::optional<std::string> text = ToText(*field, value);
      if (!text || !field->Set(*text, options)) {
        Fail(kBadFile, "{}: {}={}: {}", path_, name, Shown(value), field->Requirement());
      }
    }
  }
}

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
  if (line.command->command == kRefine) {  // --config may hold pruning options
    settings.options.pruning = PresetOf(*line.command, settings.preset, flags.method).pruning;
  }
  if (flags.fixed_model) {
    settings.options.density.enabled = false;
    settings.options.pruning = gs::PruningOptions::None();
    settings.options.adam.sh_degree_interval = 0;
  }
  gs::ValidateOptions(settings.options);
  return settings;
}

gs::LoadSceneOptions SceneOptions(const Flags& flags, const gs::TrainOptions& options) {
  gs::LoadSceneOptions scene;
  UseSceneFlags(flags, options.memory.budget_gib, &scene);
  scene.downscale = options.downscale;
  scene.background = ToFloat(options.background);
  scene.eps2d = options.eps2d, scene.antialiased = options.antialias;
  scene.random_points.seed = options.seed;
  scene.finds_points = true;
  scene.hold_out = options.target_psnr > 0;
  return scene;
}

void UseComputeFlags(const Flags& flags) {
  CheckDevice(flags.device);
  SetNumThreads(flags.threads);
}

}  // namespace vesta::app
