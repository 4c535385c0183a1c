// SPDX-License-Identifier: Apache-2.0
// view: shows a splat or a checkpoint in the browser.
#include <poll.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "apps/cli/print.h"
#include "apps/cli/process.h"
#include "apps/commands/commands.h"
#include "apps/inputs/scene_and_splat.h"
#include "apps/training/checkpointing.h"
#include "apps/viewer/viewer.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "splatting/train/trainer.h"

namespace vesta::app {
namespace {

struct ToView {
  PosedModel posed;
  std::vector<gs::ViewUnknowns> cameras;  // refined cameras of the training views; empty: not refined
};

void LoadCheckpoint(const CommandLine& line, ToView* to_view) {
  const gs::Checkpoint checkpoint = gs::ReadCheckpoint(line.arguments[0]);
  const Origin origin = ReadOrigin(checkpoint);
  PosedModel& posed = to_view->posed;
  posed.model = gs::ModelOfCheckpoint(checkpoint, origin.settings.options);
  UseRenderingFlags(line.flags, &posed.model);
  if (line.arguments.size() < 2) return;
  // Loads the scene with the flags of the training, because the checkpoint uses its frame, but with this --downscale.
  Flags flags = line.flags;
  for (const auto& [name, value] : origin.scene_flags) RestoreSceneFlag(name, value, &flags);
  gs::LoadSceneOptions options = SceneOptions(flags, origin.settings.options);
  options.downscale = flags.downscale;
  UseSplatRendering(posed.model, &options);
  posed.scene = LoadSceneOfSplat(line.arguments[1], options);
  PrintLines(posed.scene.notes);
  const auto trained = gs::NumTrainingViews(posed.scene);
  if (checkpoint.run.cameras.empty() || trained == std::ssize(checkpoint.run.cameras)) {
    to_view->cameras = checkpoint.run.cameras;
  } else {
    Print(
        "{}: it has refined cameras of {} training views, but the scene has {} training views; showing the cameras of "
        "the "
        "scene\n",
        line.arguments[0], checkpoint.run.cameras.size(), trained);
  }
}

ToView LoadToView(const CommandLine& line) {
  ToView to_view;
  const bool has_scene = line.arguments.size() > 1;
  if (gs::IsCheckpoint(line.arguments[0])) {
    LoadCheckpoint(line, &to_view);
  } else if (has_scene) {
    to_view.posed = LoadPosedModel(line);
  } else {
    to_view.posed.model = LoadSplat(line.arguments[0]);
    UseRenderingFlags(line.flags, &to_view.posed.model);
  }
  if (!has_scene) to_view.posed.scene.extent = ExtentOf(to_view.posed.model);
  return to_view;
}

}  // namespace

int RunView(const CommandLine& line) {
  const Flags& flags = line.flags;
  ToView to_view = LoadToView(line);
  PosedModel& posed = to_view.posed;
  const std::array<float, 3> background = posed.model.background;
  ShownModel shown;
  shown.Put(std::make_shared<const gs::SplatModel>(std::move(posed.model)), to_view.cameras);
  const Viewer viewer(AddressOfViewer(flags), posed.scene, background, shown);
  CatchInterrupts("\n");
  Print("{}\nPress Ctrl-C to end\n", viewer.link());
  std::fflush(stdout);
  constexpr int kMilliseconds = 200;
  while (!Interrupted()) ::poll(nullptr, 0, kMilliseconds);
  return 0;
}

}  // namespace vesta::app
