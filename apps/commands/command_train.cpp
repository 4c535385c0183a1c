// SPDX-License-Identifier: Apache-2.0
// train: trains a splat from a scene, and writes DIR/point_cloud.ply and DIR/metrics.json.
#include <algorithm>
#include <optional>

#include "apps/cli/process.h"
#include "apps/commands/commands.h"
#include "apps/device/device.h"
#include "apps/device/ranks.h"
#include "apps/inputs/scene_and_splat.h"
#include "apps/training/checkpointing.h"
#include "apps/training/train_and_write.h"
#include "apps/viewer/viewer.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/process_memory.h"
#include "splatting/train/trainer.h"

namespace vesta::app {
namespace {

ExpectedModel ExpectedOf(const gs::Scene& scene, const gs::TrainOptions& options) {
  const Index least = std::min(scene.points.size(), options.density.max_gaussians);
  const bool grows = options.density.enabled && options.adam.runs();
  // Few scenes grow by more than this; space for max_gaussians would rarely be needed.
  constexpr Index kUsualGrowth = 16, kFew = 50000;
  const Index usual = std::max(kUsualGrowth * least, kFew);
  constexpr int kHighestDegree = 3;
  return {grows ? std::min(options.density.max_gaussians, usual) : least, least,
          options.sh_degree.value_or(kHighestDegree)};
}

}  // namespace

int RunTrain(const CommandLine& given) {
  CommandLine line = given;
  Flags& flags = line.flags;
  if (!flags.view.empty()) {
    AddressOfTrainingView(flags);  // fails before input is read
    if (NumStartedRanks() > 1)
      Fail(kUnsupported, "--view: not available with several processes; start one process, or leave the flag out");
  }
  std::optional<gs::Checkpoint> checkpoint;
  std::optional<Origin> origin;
  CheckIntervals(flags);
  if (!flags.resume.empty()) {
    const std::string file = CheckpointFile(flags.resume);
    if (!FileExists(file))
      Fail(kNotFound, "{}: no such file; a training run writes it if --checkpoint_every is given", file);
    checkpoint = gs::ReadCheckpoint(file);
    origin = ReadOrigin(*checkpoint);
    // A resumed training keeps the intervals of the first one.
    if (flags.checkpoint_every.empty()) flags.checkpoint_every = origin->checkpoint_every;
    if (flags.snapshot_every.empty()) flags.snapshot_every = origin->snapshot_every;
    for (const auto& [name, value] : origin->scene_flags) {
      if (!RestoreSceneFlag(name, value, &flags)) {
        Fail(kBadFile, "{}: --{}={}, a flag of its training, is not a flag of this program; start a new training",
             checkpoint->path, name, value);
      }
    }
  }
  const std::string path = line.arguments.empty() ? origin->scene : line.arguments[0];
  TrainSettings settings = SettingsOf(line, origin ? &origin->settings : nullptr);
  gs::TrainOptions& options = settings.options;
  if (checkpoint) CheckResumable(*checkpoint, origin->settings, settings);
  CheckSceneFolder(path);
  // The checkpoint does not count as an input: the next one may overwrite it.
  const std::string folder = flags.out.empty() ? flags.resume : flags.out;
  std::optional<OutputFolder> out;
  const gs::Scene scene = FirstRankFirst([&] {
    if (!IsFirstRank()) return gs::LoadScene(path, SceneOptions(flags, options));
    RunFiles files = FilesOf(line);
    files.ReadsScene(path);
    RegisterResults(flags, folder, &files);
    files.Check();
    out.emplace(folder);
    gs::Scene loaded = gs::LoadScene(path, SceneOptions(flags, options));
    files.ReadsScene(path, loaded);
    files.Check();
    return loaded;
  });
  PrintScene(scene);
  const double load_seconds = SecondsSinceStart();
  const double held_mib = MemoryMib();
  const gs::StageRunners stages = StagesOf(flags.device);
  const TrainingJob job{.line = line,
                        .path = path,
                        .scene = scene,
                        .settings = settings,
                        .stages = stages,
                        .expected = ExpectedOf(scene, options),
                        .load_seconds = load_seconds,
                        .out = out ? &*out : nullptr};
  return TrainAndWrite(job, [&](gs::TrainCallbacks& callbacks) {
    callbacks.checkpoint.origin =
        OriginText({path, settings, flags.checkpoint_every, flags.snapshot_every, SceneFlagTexts(flags)});
    callbacks.resume = checkpoint ? &*checkpoint : nullptr;
    return gs::Train(scene, options, {SecondsSinceStart(), held_mib}, callbacks, stages);
  });
}

}  // namespace vesta::app
