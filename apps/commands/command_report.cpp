// SPDX-License-Identifier: Apache-2.0
// report: writes an HTML report of finished trainings.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <optional>

#include "apps/cli/outputs.h"
#include "apps/cli/print.h"
#include "apps/commands/commands.h"
#include "apps/inputs/scene_and_splat.h"
#include "apps/report/report.h"
#include "apps/settings/train_settings.h"
#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::app {
namespace {

// Finished runs: their splats, loaded again with their scenes. Keeps one splat and one scene in memory.
class FinishedRuns {
 public:
  // scene: scene folder of all runs; empty: the one in each metrics.json.
  FinishedRuns(const std::vector<std::string>& folders, const std::string& scene) {
    for (const std::string& folder : folders) {
      RunRecord record = ReadRun(folder);
      const std::string path = scene.empty() ? record.Text("scene") : scene;
      const double downscale = record.Number("options.train.downscale");
      const std::string named =
          path.empty() ? folder : SceneToReport(path, downscale >= 1 ? static_cast<int>(downscale) : 1);
      runs_.push_back({folder, path, record.json().dump()});
      sources_.push_back({std::move(record), named});
    }
  }

  const std::vector<RunSource>& sources() const { return sources_; }
  std::vector<std::string> scenes() const {
    std::vector<std::string> scenes;
    for (const Run& run : runs_) {
      if (!run.scene.empty()) scenes.push_back(run.scene);
    }
    return scenes;
  }

  PosedSplat Load(std::size_t number) {
    const Run& run = runs_[number];
    if (run.scene.empty()) Fail(kBadArgument, "metrics.json does not name the scene; give --scene=SCENE");
    model_ = LoadSplat(SplatFile(run.folder));
    gs::TrainOptions options = gs::PresetOptions(kDefaultPreset);
    const ConfigFile metrics(run.folder + "/metrics.json", run.metrics);
    metrics.Apply(options);
    Flags flags;
    std::string flag_texts;
    for (const auto& [name, value] : metrics.Texts("scene_flags")) {
      if (!RestoreSceneFlag(name, value, &flags))
        Fail(kBadFile, "--{}={}, a flag of its training, is not a flag of this program", name, value);
      flag_texts += fmt::format(" --{}={}", name, value);
    }
    gs::LoadSceneOptions how = SceneOptions(flags, options);
    UseSplatRendering(model_, &how);
    const std::string key = fmt::format("{} {} {} {}{} {}", sources_[number].scene, fmt::join(how.background, ","),
                                        how.eps2d, how.antialiased, flag_texts, how.hold_out);
    if (!scene_ || key != scene_key_) {
      scene_.reset();  // before the next scene is loaded
      scene_ = gs::LoadScene(run.scene, how);
      scene_key_ = key;
    }
    gs::MoveToScene(*scene_, &model_);
    return {&model_, &*scene_};
  }

  static std::string SplatFile(const std::string& folder) {
    return (std::filesystem::path(folder) / "point_cloud.ply").string();
  }

 private:
  struct Run {
    std::string folder, scene, metrics;
  };
  std::vector<Run> runs_;
  std::vector<RunSource> sources_;
  gs::SplatModel model_;
  std::optional<gs::Scene> scene_;
  std::string scene_key_;
};

}  // namespace

int RunReport(const CommandLine& line) {
  const std::vector<std::string>& folders = line.arguments;
  const Flags& flags = line.flags;
  if (folders.size() > 1 && flags.out.empty()) throw UsageError("a report of several runs needs --out=FILE");
  const std::string file = flags.out.empty() ? folders[0] + "/report.html" : flags.out;
  FinishedRuns runs(folders, flags.scene);
  RunFiles files;
  for (const std::string& folder : folders) {
    files.Reads(folder + "/metrics.json");
    files.Reads(FinishedRuns::SplatFile(folder));
  }
  for (const std::string& scene : runs.scenes()) files.ReadsScene(scene);
  files.Writes(FlagText("out", file), file);
  files.Check();
  CheckWritable("out", file);
  const auto missing = WriteReport(file, runs.sources(), [&](std::size_t run) { return runs.Load(run); });
  for (const std::string& note : missing) Print("{}\n", OneLine(note));
  Print("wrote {}\n", file);
  return 0;
}

}  // namespace vesta::app
