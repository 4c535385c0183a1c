// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "splatting/io/scenes/colmap.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/scene_promise.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/seed_model.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {
namespace {

bool Same(const gs::ColmapModel& a, const gs::ColmapModel& b) {
  const auto same_image = [](const gs::ColmapImage& i, const gs::ColmapImage& j) {
    return i.id == j.id && i.rotation == j.rotation && i.translation == j.translation && i.camera_id == j.camera_id &&
           i.name == j.name;
  };
  const auto same_point = [](const gs::ColmapPoint& p, const gs::ColmapPoint& q) {
    return p.id == q.id && p.position == q.position && p.color == q.color;
  };
  return a.cameras.size() == b.cameras.size() &&
         std::equal(a.images.begin(), a.images.end(), b.images.begin(), b.images.end(), same_image) &&
         std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(), same_point);
}

// A scene in each format; one file is replaced by the input.
struct Scenes {
  ScratchFolder folder;
  std::array<std::string, 2> names{"binary", "text"};

  std::string Model(std::size_t format) const { return folder / (names[format] + "/sparse/0"); }
  Scenes() {
    for (std::size_t format = 0; format < 2; ++format) {
      gs::WriteColmapModel(SeedModel(), Model(format), static_cast<gs::ColmapFormat>(format));
    }
  }
};

}  // namespace

void FuzzColmap(std::string_view bytes) {
  static const Scenes scenes;
  static constexpr const char* kFiles[] = {"cameras.bin", "images.bin", "points3D.bin",
                                           "cameras.txt", "images.txt", "points3D.txt"};
  if (bytes.empty() || bytes[0] < '0' || bytes[0] > '5') return;
  const auto choice = static_cast<std::size_t>(bytes[0] - '0'), format = choice / 3;
  const ScratchFolder& folder = scenes.folder;
  const std::string name = scenes.names[format] + "/sparse/0/" + kFiles[choice];
  static std::array<std::string, 6> intact;  // filled when a file is first needed
  if (intact[choice].empty()) intact[choice] = folder.Read(name);

  folder.Write(name, bytes.substr(1));
  gs::ColmapModel model;
  const bool reads = Reads(scenes.Model(format), [&] { model = gs::ReadColmapModel(scenes.Model(format)); });
  gs::Scene scene;
  const std::string scene_folder = folder / scenes.names[format];
  const bool sees = Reads(scene_folder, [&] { scene = gs::ReadColmapScene(scene_folder, "images"); });
  folder.Write(name, intact[choice]);

  Promise(reads || !sees, "a scene was loaded from an unreadable model");
  if (sees) PromiseScene(scene);
  if (!reads) return;
  gs::WriteColmapModel(model, folder / "copy", gs::ColmapFormat::kBinary);
  Promise(Same(model, gs::ReadColmapModel(folder / "copy")), "writing and reading changes the model");
}

}  // namespace vesta::fuzz
