#include "problems/gaussian_splatting/io/load_scene.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/io/byte_reader.h"
#include "problems/gaussian_splatting/io/colmap.h"
#include "problems/gaussian_splatting/io/exif.h"
#include "problems/gaussian_splatting/io/image.h"
#include "problems/gaussian_splatting/io/masks.h"
#include "problems/gaussian_splatting/io/nerf.h"
#include "problems/gaussian_splatting/io/scene_path.h"
#include "problems/gaussian_splatting/model/undistort.h"

namespace vesta::gs {

namespace {

Scene ReadModel(const std::string& path, const LoadSceneOptions& options) {
  if (!FolderExists(path)) Fail("{}: no such scene folder", path);
  const std::string& images = options.image_folder;
  if (images.empty() || LeavesScene("", images)) {
    Fail("--images={}: not a folder within the scene; move the photographs there", Printable(images));
  }
  if (images != LoadSceneOptions().image_folder && !FolderExists(path + "/" + images)) {
    Fail("{}/{}: no such folder; --images names the one that has the photographs", path, images);
  }
  if (!FindColmapModel(path).empty()) return ReadColmapScene(path, images, options.random_points);
  if (IsNerfScene(path)) return ReadNerfScene(path, options.random_points, images, options.allow_missing);
  Fail("{}: not a scene; it has neither sparse/0 (COLMAP) nor transforms.json or transforms_train.json (NeRF)", path);
}

void LeaveOutMissing(const std::string& path, bool allowed, Scene* scene) {
  std::vector<View>& views = scene->views;
  const auto is_missing = [](const View& view) { return !FileExists(view.image_path); };
  const auto first = std::find_if(views.begin(), views.end(), is_missing);
  if (first == views.end()) return;
  const auto missing = std::count_if(first, views.end(), is_missing), all = std::ssize(views);
  if (!allowed || missing == all) {
    Fail(
        "{}: no such image, but the model in {} names it ({} of {} images are missing); add it, remove it from the "
        "model{}",
        first->image_path, path, missing, all,
        missing == all ? "" : ", or leave out what is missing by --allow_missing");
  }
  std::erase_if(views, is_missing);
  scene->notes.push_back(
      fmt::format("{} of {} photographs that the model names are missing and left out", missing, all));
}

// The pinhole that will stand for the view's camera, before --downscale.
Camera UndistortedCamera(const View& view, const Camera& camera) {
  const std::optional<Camera> pinhole = PinholeOf(camera, view.distortion);
  if (pinhole) return *pinhole;
  Fail(
      "{}: the distortion of its camera leaves less than a fifth of the image's width or height to see undistorted; "
      "calibrate the camera again, or remove its images from the model",
      view.image_path);
}

// By the sizes of the cameras, before any image is decoded.
void CheckMemory(const LoadSceneOptions& options, const std::vector<View>& views) {
  if (options.memory_budget_gib <= 0) return;
  double bytes = 0;
  for (const View& view : views) {
    const Camera camera = UndistortedCamera(view, view.camera);
    const ImageSize size = DownscaledSize({camera.width, camera.height}, options.downscale);
    bytes += 3.0 * sizeof(float) * size.width * size.height;
  }
  const double gib = bytes / (1 << 30);
  if (gib <= options.memory_budget_gib) return;
  Fail("--memory_budget={}: the {} images alone take {:.2f} GiB; allow more, or use --downscale",
       options.memory_budget_gib, views.size(), gib + 0.005);
}

// Whether an image of that size can be the camera's, but for the scale.
bool HasShapeOf(const Camera& camera, ImageSize size) {
  const double height_at_width = static_cast<double>(camera.height) * size.width / camera.width;
  const double width_at_height = static_cast<double>(camera.width) * size.height / camera.height;
  return std::abs(height_at_width - size.height) <= 1 || std::abs(width_at_height - size.width) <= 1;
}

// The photograph as the camera has it. Most programs find cameras of images as they are stored; those that turn them
// upright first, as their EXIF says, leave a camera of swapped sides.
Image LoadPhotograph(const View& view, const std::array<float, 3>& background) {
  const Camera& camera = view.camera;
  Image image = LoadImage(view.image_path, background);
  if (HasShapeOf(camera, {image.width, image.height})) return image;
  if (HasShapeOf(camera, {image.height, image.width})) {
    image = TurnedUpright(image, ExifOrientation(ReadFile(view.image_path)));
    if (HasShapeOf(camera, {image.width, image.height})) return image;
  }
  Fail(
      "{}: {} x {} pixels, but its camera has {} x {}, another aspect ratio; use the images the model was made "
      "from",
      view.image_path, image.width, image.height, camera.width, camera.height);
}

void CheckSomethingCounts(const View& view, const Image& image) {
  if (CountedPixels(image) > 0) return;
  Fail("{}: by its mask or its alpha nothing of it would be trained on or measured; remove it from the model",
       view.image_path);
}

void LoadPixels(const LoadSceneOptions& options, bool alpha_is_mask, View* view) {
  Image image = LoadPhotograph(*view, options.background);
  if (!alpha_is_mask) image.mask.clear();
  if (!view->mask_path.empty()) ApplyMask(view->mask_path, &image);
  Camera camera = ResizeCamera(view->camera, image.width, image.height);
  if (!view->distortion.is_none()) {
    const Camera pinhole = UndistortedCamera(*view, camera);
    image = UndistortImage(image, camera, view->distortion, pinhole);
    camera = pinhole;
    view->distortion = {};
  }
  const ImageSize size = DownscaledSize({image.width, image.height}, options.downscale);
  if (options.downscale > 1) image = ResizeArea(image, size.width, size.height);
  view->camera = ResizeCamera(camera, size.width, size.height);
  CheckSomethingCounts(*view, image);
  view->image = std::move(image);
}

void NoteDistortion(Scene* scene) {
  const auto distorted =
      std::ranges::count_if(scene->views, [](const View& view) { return !view.distortion.is_none(); });
  if (distorted == 0) return;
  scene->notes.push_back(fmt::format(
      "{} of {} photographs are undistorted on loading: trained on and measured is what pinholes see of them",
      distorted, scene->views.size()));
}

}  // namespace

Scene LoadScene(const std::string& path, const LoadSceneOptions& options) {
  Scene scene = ReadModel(path, options);
  const std::size_t named = scene.views.size();
  ChooseTestViews(options.test_views, &scene.views);
  if (!options.test_views.list.empty()) scene.files.push_back(options.test_views.list);
  LeaveOutMissing(path, options.allow_missing, &scene);
  const bool chosen = options.test_views.every || !options.test_views.list.empty();
  if (std::ranges::all_of(scene.views, [](const View& view) { return view.is_test(); })) {
    Fail("{}: no view is left to train on, as {} for testing; add images, or choose by --test_every", path,
         chosen ? "all are" : "every 8th from the first is");
  }
  if (chosen || scene.views.size() < named) scene.extent = SceneExtent(scene.views, scene.points);
  if (options.hold_out) HoldOut(&scene.views);
  FindMasks(path, &scene);
  NoteDistortion(&scene);
  CheckMemory(options, scene.views);
  // Those of NeRF scenes are rendered over nothing, and trained over the background.
  const bool alpha_is_mask = !FindColmapModel(path).empty();
  ParallelFor(static_cast<Index>(scene.views.size()), 1,
              [&](Index i) { LoadPixels(options, alpha_is_mask, &scene.views[static_cast<std::size_t>(i)]); });
  return scene;
}

}  // namespace vesta::gs
