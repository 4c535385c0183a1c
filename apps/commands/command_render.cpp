// SPDX-License-Identifier: Apache-2.0
// render: renders the test views or a camera path, and optionally a video of the path.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "apps/cli/outputs.h"
#include "apps/cli/print.h"
#include "apps/commands/commands.h"
#include "apps/inputs/scene_and_splat.h"
#include "apps/render/film.h"
#include "apps/render/shown_views.h"
#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "splatting/io/scenes/nerf.h"

namespace vesta::app {
namespace {

// The views to render and their file names.
struct Frames {
  CameraPath path;
  std::vector<const gs::View*> views;  // in `path` or in the scene
  std::vector<std::string> names;
};

void TakePath(const Flags& flags, const gs::Scene& scene, Frames* frames) {
  frames->path = PathOfFlags(flags, scene);
  for (gs::View& view : frames->path.views) {
    view.name = fmt::format("{:05}.png", frames->views.size());
    frames->names.push_back(view.name);
    frames->views.push_back(&view);
  }
}

void TakeTestViews(const gs::Scene& scene, const ShownViews& shown, Frames* frames) {
  for (const gs::View& view : scene.views) {
    if (view.is_test()) frames->views.push_back(&view);
  }
  frames->names = FileNames(frames->views, [&](const std::string& name) { return shown.FilesOf(name); });
}

// Returns null without --film.
std::unique_ptr<Film> BeginFilm(const Flags& flags, const Frames& frames) {
  constexpr double kUsualRate = 30;
  if (flags.film.empty()) return nullptr;
  const gs::Camera& first = frames.views.front()->camera;
  for (const gs::View* view : frames.views) {
    if (view->camera.width == first.width && view->camera.height == first.height) continue;
    Fail(kBadArgument, "{}: the cameras of {} have images of different sizes; give --size=WxH",
         FlagText("film", flags.film), flags.path);
  }
  return std::make_unique<Film>(flags.film, gs::ImageSize{first.width, first.height}, flags.fps.value_or(kUsualRate));
}

// Writes the rendered cameras in world coordinates, for other programs.
void WriteCameras(const std::string& file, const gs::Scene& scene, const Frames& frames, const ShownViews& shown,
                  Show show) {
  std::vector<gs::View> cameras;
  for (std::size_t i = 0; i < frames.views.size(); ++i) {
    gs::View& camera = cameras.emplace_back();
    camera.name = frames.names[i];
    camera.camera = frames.views[i]->camera;
    camera.rotation = frames.views[i]->rotation, camera.translation = frames.views[i]->translation;
    gs::MoveToWorld(scene, &camera);
  }
  std::vector<std::pair<std::string, double>> more;
  if (IsDepth(show)) more.emplace_back("depth_unit", shown.depth_unit());
  gs::WriteNerfCameras(file, cameras, more);
}

}  // namespace

int RunRender(const CommandLine& line) {
  const Flags& flags = line.flags;
  CheckPathFlags(flags);
  const std::string given = FlagText("out", flags.out);
  const bool has_path = !flags.path.empty(), has_cameras = has_path || IsDepth(flags.show);
  RunFiles files = FilesOf(line);
  if (flags.path.ends_with(".json")) files.Reads(flags.path);
  files.WritesInto(given, flags.out);
  if (!flags.film.empty()) files.Writes(FlagText("film", flags.film), flags.film);
  files.Check();
  if (!flags.film.empty()) CheckFilm(flags.film);
  OutputFolder out(flags.out);
  if (has_cameras) files.Writes(given, out.File("cameras.json"));
  files.Check();
  const PosedModel posed = LoadPosedModel(line);
  files.ReadsScene(line.arguments[1], posed.scene);
  ShownViews shown(posed, flags.show);
  Frames frames;
  has_path ? TakePath(flags, posed.scene, &frames) : TakeTestViews(posed.scene, shown, &frames);
  // The files of a path are not checked: they are many, and each is written atomically.
  if (!has_path) {
    for (const std::string& name : frames.names) {
      for (const std::string& file : shown.FilesOf(name)) files.Writes(given, out.File(file));
    }
  }
  files.Check();
  const std::unique_ptr<Film> film = BeginFilm(flags, frames);
  for (std::size_t i = 0; i < frames.views.size(); ++i) {
    const gs::Image image = shown.Draw(*frames.views[i], flags.out, frames.names[i], flags.truth);
    out.Keep();
    if (film) film->Add(image);
  }
  if (has_cameras) WriteCameras(out.File("cameras.json"), posed.scene, frames, shown, flags.show);
  if (film) film->Finish();
  if (!frames.path.note.empty()) Print("{}\n", frames.path.note);
  Print("wrote {} images to {}{}\n", frames.views.size(), flags.out, film ? " and " + flags.film : "");
  return 0;
}

}  // namespace vesta::app
