// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/load_scene.h"

#include <algorithm>
#include <string_view>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/profile.h"
#include "splatting/io/scenes/colmap.h"
#include "splatting/io/scenes/find_photograph.h"
#include "splatting/io/scenes/nerf.h"
#include "splatting/io/scenes/photographs.h"
#include "splatting/points/plane_sweep.h"

namespace vesta::gs {
namespace {

void ChooseListed(const std::string& path, std::vector<View>* views) {
  const std::string text = ReadFile(path);
  for (View& view : *views) view.role = ViewRole::kTraining;
  std::string_view rest = text, line;
  for (Index number = 1; NextLine(&rest, &line); ++number) {
    const std::string name = WithSlashes(std::string(Trimmed(line)));
    if (name.empty() || name.front() == '#') continue;
    const auto view = std::find_if(views->begin(), views->end(), [&](const View& v) { return v.name == name; });
    if (view == views->end()) {
      Fail(kNotFound, "{}: line {}: the scene has no photograph {}; write names as in the model, for example {}", path,
           number, Printable(name), Printable(views->front().name));
    }
    view->role = ViewRole::kTest;
  }
}

// For messages: the command that finds the cameras of the photographs in a folder.
std::string ReconstructCommand(const std::string& path) {
  return fmt::format("`vesta reconstruct {}{} --out=SCENE` finds the cameras of photographs", path,
                     FolderExists(path + "/images") ? "/images" : "");
}

// COLMAP's mapper leaves an empty folder if it finds no cameras.
void CheckHasModel(const std::string& path, const std::string& model) {
  for (const char* name : {"/cameras", "/images", "/points3D"}) {
    for (const char* extension : {".bin", ".txt"}) {
      if (FileExists(model + name + extension)) return;
    }
  }
  Fail(kNotFound, "{}: no COLMAP model in this folder; {}", model, ReconstructCommand(path));
}

Scene ReadModel(const std::string& path, const LoadSceneOptions& options) {
  if (!FolderExists(path)) Fail(kNotFound, "{}: no such scene folder", path);
  const std::string& images = options.image_folder;
  if (images.empty() || LeavesScene("", images)) {
    Fail(kBadArgument, "--images={}: not a folder within the scene; move the photographs there", Printable(images));
  }
  if (images != LoadSceneOptions().image_folder && !FolderExists(path + "/" + images)) {
    Fail(kNotFound, "{}/{}: no such folder; set --images to the folder with the photographs", path, images);
  }
  if (const std::string model = FindColmapModel(path); !model.empty()) {
    CheckHasModel(path, model);
    return ReadColmapScene(path, images, options.random_points);
  }
  if (IsNerfScene(path)) {
    return ReadNerfScene(path, {options.random_points, images, options.allow_missing, !options.test_views.is_given()});
  }
  Fail(kBadFile,
       "{}: not a scene; it has neither sparse/0 (COLMAP) nor transforms.json or transforms_train.json (NeRF); {}",
       path, ReconstructCommand(path));
}

void LeaveOutMissing(const std::string& path, bool allowed, Scene* scene) {
  std::vector<View>& views = scene->views;
  const auto is_missing = [](const View& view) { return !FileExists(view.image_path); };
  const auto first = std::find_if(views.begin(), views.end(), is_missing);
  if (first == views.end()) return;
  const auto missing = std::count_if(first, views.end(), is_missing), all = std::ssize(views);
  if (!allowed || missing == all) {
    Fail(kNotFound,
         "{}: no such image, but the model in {} names it ({} of {} images are missing); add it, remove it from the "
         "model{}",
         first->image_path, path, missing, all,
         missing == all ? ", or set --images to their folder" : ", or skip missing images with --allow_missing");
  }
  std::erase_if(views, is_missing);
  scene->notes.push_back(
      fmt::format("{} of {} photographs that the model names are missing and left out", missing, all));
}

// PhotographFinder may have found files with other names.
void NoteOtherNames(Scene* scene) {
  const auto is_other = [](const View& view) {
    return std::filesystem::path(view.image_path).filename() != std::filesystem::path(view.name).filename();
  };
  const auto count = std::ranges::count_if(scene->views, is_other);
  if (count == 0) return;
  const View& first = *std::ranges::find_if(scene->views, is_other);
  scene->notes.push_back(
      fmt::format("{} photographs have other names than in the model; for example, {} is used for {}", count,
                  std::filesystem::path(first.image_path).filename().string(), first.name));
}

void NoteDistortion(Scene* scene) {
  const auto distorted =
      std::ranges::count_if(scene->views, [](const View& view) { return !view.distortion.is_none(); });
  if (distorted == 0) return;
  scene->notes.push_back(
      fmt::format("{} of {} photographs are undistorted on loading; training and metrics use the undistorted images",
                  distorted, scene->views.size()));
}

// Points on surfaces take the place of random ones.
void FindPoints(const RandomPoints& random, Scene* scene) {
  const PointCloud found = PointsByPlaneSweep(scene->views, random.count, random.seed);
  if (found.size() == 0) return;
  std::ranges::copy(found.positions, scene->points.positions.begin());
  std::ranges::copy(found.colors, scene->points.colors.begin());
  scene->extent = SceneExtent(scene->views, scene->points);
  const std::string note = fmt::format("{}; {} of them are then replaced by points found in the photographs",
                                       scene->points_note, found.size());
  std::ranges::replace(scene->notes, scene->points_note, note);
  scene->points_note = note;
}

}  // namespace

void ChooseTestViews(const TestViews& choice, std::vector<View>* views) {
  if (choice.every && !choice.list.empty()) Fail(kBadArgument, "--test_every and --test_list: give only one of them");
  if (choice.every) SplitByCount(*choice.every, views);
  if (!choice.list.empty()) ChooseListed(choice.list, views);
}

Scene LoadScene(const std::string& path, const LoadSceneOptions& options) {
  const ScopedPhase phase("load scene");
  VESTA_CHECK(splat::IsValidEps2d(options.eps2d), "eps2d of {} pixels^2", options.eps2d);
  Scene scene = ReadModel(path, options);
  const std::size_t named = scene.views.size();
  const TestViews& choice = options.test_views;
  ChooseTestViews(choice, &scene.views);
  if (choice.every) scene.split = fmt::format("--test_every={}", *choice.every);
  if (!choice.list.empty()) {
    scene.split = "--test_list";
    scene.files.push_back(choice.list);
  }
  LeaveOutMissing(path, options.allow_missing, &scene);
  const bool has_training = NumTrainingViews(scene) > 0;
  if (!has_training && !options.may_lack_training) {
    Fail(kBadArgument, "{}: no training view is left, since all are test views ({}); add images, or set --test_every",
         path, scene.split);
  }
  if (has_training && (choice.is_given() || scene.views.size() < named))
    scene.extent = SceneExtent(scene.views, scene.points);
  if (options.hold_out) HoldOut(&scene.views);
  NoteOtherNames(&scene);
  FindMasks(path, &scene);
  NoteDistortion(&scene);
  // Images of NeRF scenes have no background: they are composited over the training background.
  const bool alpha_is_mask = !FindColmapModel(path).empty();
  LoadPhotographs({options.downscale, options.background, alpha_is_mask}, options.photographs_bytes, &scene);
  if (options.finds_points && !scene.points_note.empty()) FindPoints(options.random_points, &scene);
  for (View& view : scene.views) {
    view.camera.eps2d = options.eps2d, view.camera.antialiased = options.antialiased;
  }
  return scene;
}

}  // namespace vesta::gs
