#include "problems/gaussian_splatting/io/load_scene.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/io/byte_reader.h"
#include "problems/gaussian_splatting/io/colmap.h"
#include "problems/gaussian_splatting/io/image.h"
#include "problems/gaussian_splatting/model/undistort.h"

namespace vesta::gs {

namespace {

Scene ReadModel(const std::string& path, const LoadSceneOptions& options) {
  if (!FolderExists(path)) Fail("{}: no such scene folder", path);
  if (!FindColmapModel(path).empty()) return ReadColmapScene(path, options.image_folder);
  if (IsNerfScene(path)) return ReadNerfScene(path, options.random_points);
  Fail("{}: not a scene; it has neither sparse/0 (COLMAP) nor transforms.json or transforms_train.json (NeRF)", path);
}

void CheckImageFiles(const std::string& path, const std::vector<View>& views) {
  const auto is_missing = [](const View& view) { return !FileExists(view.image_path); };
  const auto first = std::find_if(views.begin(), views.end(), is_missing);
  if (first == views.end()) return;
  Fail(
      "{}: no such image, but the model in {} names it ({} of {} images are missing); add it or remove it from the "
      "model",
      first->image_path, path, std::count_if(first, views.end(), is_missing), views.size());
}

// What a scene may hold beside what is read.
void NotePassedOver(const std::string& path, Scene* scene) {
  for (const char* name : {"masks", "mask"}) {
    if (FolderExists(path + "/" + name)) {
      scene->notes.push_back(fmt::format("{}/ is passed over: all of every image is trained on", name));
    }
  }
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

// The camera before an image of that size, which it has but for the scale.
Camera CameraOfImage(const View& view, const Image& image) {
  const Camera& camera = view.camera;
  if (image.width == camera.width && image.height == camera.height) return camera;
  const double height_at_width = static_cast<double>(camera.height) * image.width / camera.width;
  const double width_at_height = static_cast<double>(camera.width) * image.height / camera.height;
  if (std::abs(height_at_width - image.height) > 1 && std::abs(width_at_height - image.width) > 1) {
    Fail(
        "{}: {} x {} pixels, but its camera has {} x {}, another aspect ratio; use the images the model was made "
        "from",
        view.image_path, image.width, image.height, camera.width, camera.height);
  }
  return ResizeCamera(camera, image.width, image.height);
}

void LoadPixels(const LoadSceneOptions& options, View* view) {
  Image image = LoadImage(view->image_path, options.background);
  Camera camera = CameraOfImage(*view, image);
  if (!view->distortion.is_none()) {
    const Camera pinhole = UndistortedCamera(*view, camera);
    image = UndistortImage(image, camera, view->distortion, pinhole);
    camera = pinhole;
    view->distortion = {};
  }
  const ImageSize size = DownscaledSize({image.width, image.height}, options.downscale);
  if (options.downscale > 1) image = ResizeArea(image, size.width, size.height);
  view->camera = ResizeCamera(camera, size.width, size.height);
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
  CheckImageFiles(path, scene.views);
  if (std::all_of(scene.views.begin(), scene.views.end(), [](const View& view) { return view.is_test(); })) {
    Fail("{}: no view is left to train on, as every 8th from the first is for testing; add images", path);
  }
  if (options.hold_out) HoldOut(&scene.views);
  NotePassedOver(path, &scene);
  NoteDistortion(&scene);
  CheckMemory(options, scene.views);
  ParallelFor(static_cast<Index>(scene.views.size()), 1,
              [&](Index i) { LoadPixels(options, &scene.views[static_cast<std::size_t>(i)]); });
  return scene;
}

}  // namespace vesta::gs
