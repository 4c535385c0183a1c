// SPDX-License-Identifier: Apache-2.0
#include "apps/training/checkpointing.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>

#include "apps/settings/train_settings.h"
#include "kernels/core/check.h"
#include "splatting/adam/adam_options.h"

namespace vesta::app {
namespace {

using Json = nlohmann::ordered_json;

// Options that determine the model, its images, or the saved state.
constexpr const char* kFixed[] = {"adam.second_moment", "adam.batch_size",  "cameras.refine",
                                  "train.sh_degree",    "train.downscale",  "train.eps2d",
                                  "train.antialias",    "train.background", "train.seed"};

bool IsFixed(const std::string& name, gs::Stage stage) {
  for (const char* fixed : kFixed) {
    if (name == fixed) return true;
  }
  return stage == gs::Stage::kLm &&
         (name.starts_with("adam.") || name.starts_with("density.") || name.starts_with("lr."));
}

}  // namespace

gs::Interval ParseInterval(const char* flag, const std::string& text) {
  gs::Interval interval;
  if (text.empty()) return interval;
  const bool minutes = text.back() == 'm';
  const char *const begin = text.data(), *const end = begin + text.size() - (minutes ? 1 : 0);
  const auto parsed =
      minutes ? std::from_chars(begin, end, interval.minutes) : std::from_chars(begin, end, interval.iterations);
  const bool in_range = minutes ? interval.minutes > 0 && interval.minutes <= 1e6 : interval.iterations >= 1;
  if (parsed.ec != std::errc() || parsed.ptr != end || !in_range) {
    throw UsageError(fmt::format(
        "--{}={}: it must be a number of iterations, at least 1, or of minutes with an m: 500 or 10m", flag, text));
  }
  return interval;
}

void CheckIntervals(const Flags& flags) {
  ParseInterval("checkpoint_every", flags.checkpoint_every);
  ParseInterval("snapshot_every", flags.snapshot_every);
}

std::string CheckpointFile(const std::string& folder) {
  return (std::filesystem::path(folder) / "checkpoint.vesta").string();
}

std::string OriginText(const Origin& origin) {
  Json scene_flags = Json::object();
  for (const auto& [name, value] : origin.scene_flags) scene_flags[name] = value;
  const Json json = {{"scene", std::filesystem::absolute(origin.scene).lexically_normal().string()},
                     {"checkpoint_every", origin.checkpoint_every},
                     {"snapshot_every", origin.snapshot_every},
                     {"scene_flags", scene_flags},
                     {"preset", origin.settings.preset},
                     {"options", OptionsJson(origin.settings.options)}};
  return json.dump();
}

Origin ReadOrigin(const gs::Checkpoint& checkpoint) {
  const ConfigFile config(checkpoint.path, checkpoint.run.origin);
  Origin origin;
  origin.scene = config.Text("scene");
  origin.checkpoint_every = config.Text("checkpoint_every");
  origin.snapshot_every = config.Text("snapshot_every");
  origin.scene_flags = config.Texts("scene_flags");
  origin.settings.preset = config.preset();
  if (origin.settings.preset.empty()) origin.settings.preset = kDefaultPreset;
  origin.settings.options = gs::PresetOptions(origin.settings.preset);
  config.Apply(origin.settings.options);
  return origin;
}

void CheckResumable(const gs::Checkpoint& checkpoint, const TrainSettings& before, const TrainSettings& now) {
  for (const schema::Field<gs::TrainOptions>& field : gs::TrainFields()) {
    const std::string old_value = field.Text(before.options), new_value = field.Text(now.options);
    if (old_value == new_value || !IsFixed(field.name, checkpoint.run.stage)) continue;
    Fail(kBadArgument, "{}: trained with {}={}, which cannot change to {}{} {}; keep it, or start a new training",
         checkpoint.path, field.name, old_value, new_value,
         before.preset == now.preset ? "" : fmt::format(" (from --preset={})", now.preset),
         checkpoint.run.stage == gs::Stage::kLm ? "in the LM stage" : "during a training run");
  }
  const int done = checkpoint.run.stage == gs::Stage::kAdam ? checkpoint.iteration() : 0;
  const gs::AdamOptions& adam = now.options.adam;
  if (adam.iterations && gs::NumIterations(adam) <= done) {
    Fail(kBadArgument, "{}: {} iterations of Adam are done; --iterations={} must be more", checkpoint.path,
         done * adam.batch_size, *adam.iterations);
  }
}

}  // namespace vesta::app
