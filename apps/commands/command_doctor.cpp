// SPDX-License-Identifier: Apache-2.0
// doctor: describes a scene, warns about problems, and estimates time and memory of a training.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "apps/cli/print.h"
#include "apps/cli/process.h"
#include "apps/commands/commands.h"
#include "apps/device/device.h"
#include "apps/doctor/scene_warnings.h"
#include "apps/inputs/scene_and_splat.h"
#include "apps/settings/train_settings.h"
#include "kernels/core/process_memory.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/scenes/load_scene.h"
#include "splatting/train/settings/training_plan.h"
#include "splatting/train/trainer.h"

namespace vesta::app {
namespace {

const char* KindOf(const gs::Scene& scene) {
  const bool is_nerf = std::any_of(scene.files.begin(), scene.files.end(),
                                   [](const std::string& file) { return file.ends_with(".json"); });
  return is_nerf ? "a NeRF scene (transforms.json)" : "a COLMAP model";
}

double DecodedMib(const gs::Scene& scene) {
  double pixels = 0;
  for (const gs::View& view : scene.views) pixels += view.camera.pixels();
  return pixels * gs::kImageBytes / (1 << 20);
}

void PrintWhatItIs(const std::string& path, const gs::Scene& scene) {
  const gs::Camera& first = scene.views.front().camera;
  const bool is_one_size = std::all_of(scene.views.begin(), scene.views.end(), [&](const gs::View& view) {
    return view.camera.width == first.width && view.camera.height == first.height;
  });
  Print("{}: {}, {} photographs of {} x {} pixels{}, horizontal field of view {:.0f} degrees, {:.0f} MiB decoded\n",
        OneLine(path), KindOf(scene), scene.views.size(), first.width, first.height,
        is_one_size ? "" : " and other sizes", gs::HorizontalAngle(first), DecodedMib(scene));
  PrintScene(scene);
}

// Trains until the trainer makes its own prediction, then stops.
std::optional<gs::Prediction> Foresee(const gs::Scene& scene, const gs::TrainOptions& options, Device device) {
  std::optional<gs::Prediction> prediction;
  constexpr double kPatience = 20;  // seconds
  const double start = SecondsSinceStart();
  gs::TrainCallbacks callbacks;
  callbacks.predicted = [&](const gs::Prediction& foreseen) { prediction = foreseen; };
  callbacks.stop = [&] { return prediction || SecondsSinceStart() - start > kPatience; };
  const gs::TrainResult result = gs::Train(scene, options, {0, MemoryMib()}, callbacks, StagesOf(device));
  if (!prediction && !result.stopped) {  // it ended before a prediction
    const gs::HistoryRow& last = result.history.back();
    prediction = {.seconds = last.seconds + result.eval_seconds,
                  .mib = PeakMemoryMib(),
                  .gaussians = static_cast<double>(last.gaussians)};
  }
  return prediction;
}

// Empty, with a note, if the tracks are damaged: nothing else needs them.
gs::PointTracks TracksOf(const std::string& path, const gs::Scene& scene) {
  try {
    return gs::ReadTracks(path, scene);
  } catch (const Error& error) {
    Print("Note: the tracks are not used: {}\n", error.what());
    return {};
  }
}

void PrintWhatItTakes(const gs::Scene& scene, const TrainSettings& settings, Device device) {
  const gs::TrainOptions fitted = gs::FitToScene(settings.options, gs::NumTrainingViews(scene));
  Print("A training run with --preset={} takes {} iterations", settings.preset, fitted.adam.iterations.value_or(0));
  if (const std::optional<gs::Prediction> foreseen = Foresee(scene, settings.options, device)) {
    Print(": about {} on this machine, {:.0f} MiB of memory, {:.0f} Gaussians at the end (first estimate)",
          FormatDuration(foreseen->seconds), foreseen->mib, foreseen->gaussians);
  }
  Print("\n");
}

}  // namespace

int RunDoctor(const CommandLine& line) {
  const std::string& path = line.arguments[0];
  TrainSettings settings = SettingsOf(line);
  settings.options.downscale = line.flags.downscale;
  CheckSceneFolder(path);
  const gs::Scene scene = gs::LoadScene(path, SceneOptions(line.flags, settings.options));
  PrintWhatItIs(path, scene);
  const std::vector<std::string> doubts = SceneWarnings(scene, TracksOf(path, scene));
  Print("{}", doubts.empty() ? "No warnings\n" : "Warnings:\n");
  for (const std::string& doubt : doubts) Print("  {}\n", OneLine(doubt));
  std::fflush(stdout);
  PrintWhatItTakes(scene, settings, line.flags.device);
  return 0;
}

}  // namespace vesta::app
