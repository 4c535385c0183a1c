// SPDX-License-Identifier: Apache-2.0
// view: a splat, or the state of a training, in the browser.
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
  std::vector<gs::ViewUnknowns> cameras;  // of the training views, where they were found along; else empty
};

void LoadCheckpoint(const CommandLine& line, ToView* to_view) {
  const gs::Checkpoint checkpoint = gs::ReadCheckpoint(line.arguments[0]);
  const Origin origin = ReadOrigin(checkpoint);
  PosedModel& posed = to_view->posed;
  posed.model = gs::ModelOfCheckpoint(checkpoint, origin.settings.options);
  UseRenderingFlags(line.flags, &posed.model);
  if (line.arguments.size() < 2) return;
  // The scene as the training read it, in whose frame the checkpoint is, but in the size asked for.
  Flags flags = line.flags;
  for (const auto& [name, value] : origin.scene_flags) RestoreSceneFlag(name, value, &flags);
  gs::LoadSceneOptions options = SceneOptions(flags, origin.settings.options);
  options.downscale = flags.downscale;
  LoadFor(posed.model, &options);
  posed.scene = gs::LoadScene(line.arguments[1], options);
  const auto trained = gs::NumTrainingViews(posed.scene);
  if (checkpoint.run.cameras.empty() || trained == std::ssize(checkpoint.run.cameras)) {
    to_view->cameras = checkpoint.run.cameras;
  } else {
    Print("{}: found the cameras of {} training views, but the scene has {}; they are shown where the scene has them\n",
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
    to_view.posed.model = gs::ReadSplat(line.arguments[0]);
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
  const Viewer viewer(PlaceOfViewer(flags), posed.scene, background, shown);
  CatchInterrupts("\n");
  Print("{}\nCtrl-C ends it\n", viewer.link());
  std::fflush(stdout);
  constexpr int kMilliseconds = 200;
  while (!Interrupted()) ::poll(nullptr, 0, kMilliseconds);
  return 0;
}

}  // namespace vesta::app
