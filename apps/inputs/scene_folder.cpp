#include "apps/inputs/scene_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "apps/cli/print.h"
#include "apps/cli/process.h"
#include "kernels/core/check.h"
#include "kernels/core/text_file.h"

namespace vesta::app {

void CheckSceneFolder(const std::string& path) {
  if (FolderExists(path)) return;
  if (FileExists(path)) Fail("{}: a file, where the scene's folder is to be named; `vesta help` shows the order", path);
  Fail("{}: no such scene folder", path);
}

void PrintScene(const gs::Scene& scene) {
  const auto count = [&](gs::ViewRole role) {
    return std::ranges::count_if(scene.views, [&](const gs::View& view) { return view.role == role; });
  };
  const auto held_out = count(gs::ViewRole::kHeldOut);
  Print("{} views to train on, {}{} to test; {} points; loaded in {:.1f} s\n", count(gs::ViewRole::kTraining),
        held_out > 0 ? fmt::format("{} held out to judge by, ", held_out) : "", count(gs::ViewRole::kTest),
        scene.points.size(), SecondsSinceStart());
  for (const std::string& note : scene.notes) Print("{}\n", note);
  std::fflush(stdout);
}

}  // namespace vesta::app
