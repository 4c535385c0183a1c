// view: a splat, or the state of a training, in the browser.
#include <poll.h>

#include <memory>

#include "apps/checkpointing.h"
#include "apps/commands.h"
#include "apps/interrupt.h"
#include "apps/posed_model.h"
#include "apps/print.h"
#include "apps/scene_flags.h"
#include "apps/viewer/scene_json.h"
#include "apps/viewer/viewer.h"
#include "apps/viewer_flags.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "problems/gaussian_splatting/train/checkpoint_model.h"

namespace vesta::app {
namespace {

gs::SplatModel CheckpointedModel(const std::string& path) {
  const gs::Checkpoint checkpoint = gs::ReadCheckpoint(path);
  return gs::ModelOfCheckpoint(checkpoint, ReadOrigin(checkpoint).settings.options);
}

PosedModel LoadToView(const CommandLine& line) {
  const std::string& path = line.arguments[0];
  const bool is_checkpoint = gs::IsCheckpoint(path), has_scene = line.arguments.size() > 1;
  if (has_scene && !is_checkpoint) return LoadPosedModel(line);
  PosedModel posed{.model = is_checkpoint ? CheckpointedModel(path) : gs::ReadSplat(path), .scene = {}};
  if (line.flags.background) posed.model.background = ToFloat(*line.flags.background);
  if (has_scene) {  // in whose frame the checkpoint is
    gs::LoadSceneOptions options;
    options.downscale = line.flags.downscale;
    options.background = posed.model.background;
    UseSceneFlags(line.flags, 0, &options);
    posed.scene = gs::LoadScene(line.arguments[1], options);
  } else {
    posed.scene.extent = ExtentOf(posed.model);
  }
  return posed;
}

}  // namespace

int RunView(const CommandLine& line) {
  const Flags& flags = line.flags;
  PosedModel posed = LoadToView(line);
  const std::array<float, 3> background = posed.model.background;
  ShownModel shown;
  shown.Put(std::make_shared<const gs::SplatModel>(std::move(posed.model)));
  const Viewer viewer(PlaceOfViewer(flags), posed.scene, background, shown);
  CatchInterrupts("\n");
  Print("{}\nCtrl-C ends it\n", viewer.link());
  std::fflush(stdout);
  constexpr int kMilliseconds = 200;
  while (!Interrupted()) ::poll(nullptr, 0, kMilliseconds);
  return 0;
}

}  // namespace vesta::app
