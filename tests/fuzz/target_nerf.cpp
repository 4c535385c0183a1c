// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "splatting/io/images/image_file.h"
#include "splatting/io/scenes/nerf.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/scene_promise.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {
namespace {

// Files that a transforms.json can refer to: an image and points.
struct NerfFolder {
  ScratchFolder folder;
  NerfFolder() {
    gs::SavePng(folder / "a.png", gs::Image(6, 4));
    folder.Write("points.ply",
                 "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
                 "end_header\n0 0 0\n1 2 3\n");
  }
};

}  // namespace

void FuzzNerf(std::string_view bytes) {
  static const NerfFolder nerf;
  nerf.folder.Write("transforms.json", bytes);
  const std::string path = nerf.folder / "";
  gs::Scene scene;
  if (Reads(path, [&] { scene = gs::ReadNerfScene(path, {.random_points = {.count = 10}}); })) PromiseScene(scene);
}

}  // namespace vesta::fuzz
