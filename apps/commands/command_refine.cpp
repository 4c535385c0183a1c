// SPDX-License-Identifier: Apache-2.0
// refine and prune: train an existing splat further, and write DIR/point_cloud.ply and DIR/metrics.json.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "apps/cli/print.h"
#include "apps/cli/process.h"
#include "apps/commands/commands.h"
#include "apps/device/device.h"
#include "apps/device/ranks.h"
#include "apps/inputs/scene_and_splat.h"
#include "apps/training/train_and_write.h"
#include "kernels/core/check.h"
#include "kernels/core/process_memory.h"
#include "splatting/io/splats/ply.h"
#include "splatting/train/prune_at_start.h"
#include "splatting/train/trainer.h"

namespace vesta::app {
namespace {

double ModelMib(const gs::SplatModel& model) {
  return static_cast<double>(model.data.size() * sizeof(float)) / (1 << 20);
}

// The fraction of the Gaussians that fits into a .ply of `mib` MiB.
double PartIn(double mib, const gs::SplatModel& model) {
  constexpr double kHeader = 4096;  // upper bound, bytes
  const auto all = static_cast<double>(gs::SplatPlyBytes(model.count, model.sh_degree));
  const double part = (mib * (1 << 20) - kHeader) / all;
  if (part * static_cast<double>(model.count) < 1) Fail(kBadArgument, "--size_mib={}: too small for one Gaussian", mib);
  return std::min(part, 1.0);
}

bool IsGiven(const CommandLine& line, const char* option) {
  return std::ranges::any_of(line.options, [&](const GivenOption& given) { return given.field->name == option; });
}

// Checks that exactly one goal is given. It overrides pruning.keep_fraction of --config.
void CheckOneGoal(const CommandLine& line, const gs::TrainOptions& options) {
  const Flags& flags = line.flags;
  const int own = (flags.max_loss ? 1 : 0) + (flags.size_mib ? 1 : 0);
  const bool keeps = own == 0 ? options.pruning.prunes() : IsGiven(line, "pruning.keep_fraction");
  if (own + (keeps ? 1 : 0) == 0) {
    throw UsageError("how many Gaussians to remove? Give --keep=PART (below 1), --max_loss or --size_mib");
  }
  if (own + (keeps ? 1 : 0) > 1) throw UsageError("--keep, --max_loss and --size_mib: give only one of them");
}

std::string GoalText(const Flags& flags, double keep) {
  if (flags.max_loss) return fmt::format("--max_loss={}", *flags.max_loss);
  if (flags.size_mib) return fmt::format("--size_mib={}", *flags.size_mib);
  return fmt::format("--keep={}", keep);
}

// Applies `change` to options and splat, then trains. `change` returns a line for the user; may be empty.
template <class Change>
int RefineChanged(const CommandLine& line, const Change& change) {
  const std::string& ply = line.arguments[0];
  const std::string& path = line.arguments[1];
  TrainSettings settings = SettingsOf(line);
  gs::TrainOptions& options = settings.options;
  CheckSceneFolder(path);
  std::optional<OutputFolder> out;
  PosedModel posed = FirstRankFirst([&] {
    const auto load = [&] { return LoadPosedModel(ply, path, line.flags, SceneOptions(line.flags, options)); };
    if (!IsFirstRank()) return load();
    RunFiles files = FilesOf(line);
    RegisterResults(line.flags, line.flags.out, &files);
    files.Check();
    out.emplace(line.flags.out);
    PosedModel loaded = load();
    files.ReadsScene(path, loaded.scene);
    files.Check();
    return loaded;
  });
  options.background = ToDouble(posed.model.background), options.eps2d = posed.model.eps2d;
  options.antialias = posed.model.antialiased;
  PrintScene(posed.scene);
  const double load_seconds = SecondsSinceStart();
  const std::string note = change(settings.options, posed);
  const double held_mib = MemoryMib() - ModelMib(posed.model);
  const gs::StageRunners stages = StagesOf(line.flags.device);
  const TrainingJob job{.line = line,
                        .path = path,
                        .scene = posed.scene,
                        .settings = settings,
                        .stages = stages,
                        .expected = {posed.model.count, posed.model.count, posed.model.sh_degree},
                        .load_seconds = load_seconds,
                        .out = out ? &*out : nullptr};
  return TrainAndWrite(job, [&](const gs::TrainCallbacks& callbacks) {
    gs::TrainResult result =
        gs::Refine(posed.scene, std::move(posed.model), options, {SecondsSinceStart(), held_mib}, callbacks, stages);
    if (!note.empty()) result.notes.push_back(note);
    return result;
  });
}

}  // namespace

int RunRefine(const CommandLine& line) {
  return RefineChanged(line, [](const gs::TrainOptions&, const PosedModel&) { return std::string(); });
}

int RunPrune(const CommandLine& line) {
  CheckOneGoal(line, SettingsOf(line).options);
  return RefineChanged(line, [&](gs::TrainOptions& options, PosedModel& posed) {
    if (line.flags.size_mib) options.pruning.keep_fraction = PartIn(*line.flags.size_mib, posed.model);
    const std::string goal = GoalText(line.flags, options.pruning.keep_fraction);
    const std::string now = gs::PruneAtStart(posed.scene, line.flags.max_loss, options, posed.model);
    return now.empty() ? fmt::format("pruned gradually from {} Gaussians, for {}", posed.model.count, goal)
                       : fmt::format("{}, for {}", now, goal);
  });
}

}  // namespace vesta::app
