// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/photographs.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/scene/undistort.h"
#include "splatting/io/bytes/bytes.h"
#include "splatting/io/images/image_file.h"

namespace vesta::gs {
namespace {

// Camera before --downscale.
Camera UndistortedCamera(const View& view, const Camera& camera) {
  const std::optional<Camera> pinhole = PinholeOf(camera, view.distortion);
  if (pinhole) return *pinhole;
  Fail(kBadFile,
       "{}: after undistortion, less than a fifth of the image's width or height would remain; "
       "calibrate the camera again, or remove its images from the model",
       view.image_path);
}

// Whether an image of this size can belong to the camera, up to scale.
bool HasShapeOf(const Camera& camera, ImageSize size) {
  const double height_at_width = static_cast<double>(camera.height) * size.width / camera.width;
  const double width_at_height = static_cast<double>(camera.width) * size.height / camera.height;
  return std::abs(height_at_width - size.height) <= 1 || std::abs(width_at_height - size.width) <= 1;
}

// The EXIF orientation by which to rotate an image so that it fits its camera; 1 if it already fits. Some programs
// rotate images upright before they find cameras.
int OrientationFor(const View& view, ImageSize size) {
  constexpr int kFirstThatSwapsSides = 5;
  const Camera& camera = view.camera;
  if (HasShapeOf(camera, size)) return 1;
  if (HasShapeOf(camera, {size.height, size.width})) {
    const int orientation = ExifOrientation(ReadFile(view.image_path));
    if (orientation >= kFirstThatSwapsSides) return orientation;
  }
  Fail(kBadFile,
       "{}: {} x {} pixels, but its camera has {} x {}, another aspect ratio; use the images the model was made "
       "from",
       view.image_path, size.width, size.height, camera.width, camera.height);
}

// most_bytes: receives the peak memory.
Image LoadTurned(const View& view, const std::array<float, 3>& background, double* most_bytes) {
  double samples = 0;
  Image image = LoadImage(view.image_path, background, &samples);
  *most_bytes = BytesOf(image) + samples;
  const int orientation = OrientationFor(view, {image.width, image.height});
  if (orientation == 1) return image;
  *most_bytes = std::max(*most_bytes, 2 * BytesOf(image));
  return RotatedUpright(image, orientation);
}

// Cameras of the rotated photograph in its file, after undistortion, and after downscaling.
struct CameraSteps {
  Camera in_file, undistorted, downscaled;
};

CameraSteps StepsFrom(const View& view, ImageSize turned, const PhotographRule& rule) {
  CameraSteps steps;
  steps.in_file = ResizeCamera(view.camera, turned.width, turned.height);
  steps.undistorted = view.distortion.is_none() ? steps.in_file : UndistortedCamera(view, steps.in_file);
  const ImageSize size = DownscaledSize({steps.undistorted.width, steps.undistorted.height}, rule.downscale);
  steps.downscaled = ResizeCamera(steps.undistorted, size.width, size.height);
  return steps;
}

// Most bytes per pixel of Image::transparency.
double AlphaBytes(const PhotographRule& rule) { return rule.alpha_is_mask ? 0 : sizeof(float); }

// Upper bound of the temporary memory. Decoding holds the samples (four of two bytes) and the planes. Rotating,
// resampling and masks hold two sets of planes.
double MostWorkBytes(const View& view, const CameraSteps& steps, const PhotographRule& rule) {
  constexpr double kMostSampleBytes = 8;
  const double masked_bytes = kImageBytes + 1 + AlphaBytes(rule);
  const double in_file = steps.in_file.pixels(), undistorted = steps.undistorted.pixels(),
               result = steps.downscaled.pixels();
  double most = (masked_bytes + kMostSampleBytes) * in_file;
  most = std::max(most, 2 * (kImageBytes + 1) * in_file);  // only JPEGs, without alpha, are rotated
  if (!view.mask_path.empty()) most = std::max(most, (2 * masked_bytes + kMostSampleBytes) * in_file);
  if (!view.distortion.is_none()) most = std::max(most, masked_bytes * (in_file + undistorted));
  if (rule.downscale > 1) most = std::max(most, masked_bytes * (undistorted + result));
  return most - kImageBytes * result;
}

void CheckSomethingCounts(const View& view, const Image& image) {
  if (UnmaskedPixels(image) > 0) return;
  Fail(kBadFile, "{}: its mask or alpha channel excludes all pixels; remove the image from the model", view.image_path);
}

constexpr double kMib = 1 << 20;

// Two photographs must fit: one in use and one being decoded.
void CheckBudget(double budget, const std::vector<View>& views) {
  double most = 0;
  for (const View& view : views) most = std::max(most, kImageBytes * view.camera.pixels());
  if (2 * most <= budget) return;
  Fail(kOutOfMemory,
       "--photographs_mib: {:.1f} MiB are less than two photographs need, {:.1f}; increase it (the default is half of "
       "--memory_budget, if given), or use --downscale",
       budget / kMib, std::ceil(20 * most / kMib) / 10);
}

// Checks that the size is unchanged.
Image ReadAgain(const View& in_file, const PhotographRule& rule, const Camera& camera) {
  Image image = ReadPhotograph(in_file, rule).image;
  if (image.width != camera.width || image.height != camera.height) {
    Fail(kBadFile,
         "{}: its size has changed since the scene was loaded; do not change photographs while they are in use",
         in_file.image_path);
  }
  return image;
}

}  // namespace

ViewPhotograph ReadPhotograph(const View& view, const PhotographRule& rule) {
  double most_bytes = 0;
  Image image = LoadTurned(view, rule.background, &most_bytes);
  const auto replace_by = [&](Image made) {
    most_bytes = std::max(most_bytes, BytesOf(image) + BytesOf(made));
    image = std::move(made);
  };
  const CameraSteps steps = StepsFrom(view, {image.width, image.height}, rule);
  if (rule.alpha_is_mask) {
    image.transparency = std::vector<float>();
  } else {
    image.mask = std::vector<std::uint8_t>();
  }
  if (!view.mask_path.empty()) {
    const double bytes = ApplyMask(view.mask_path, &image);
    most_bytes = std::max(most_bytes, bytes + BytesOf(image));
  }
  if (!view.distortion.is_none()) {
    replace_by(UndistortImage(image, steps.in_file, view.distortion, steps.undistorted));
  }
  if (rule.downscale > 1) replace_by(ResizeArea(image, steps.downscaled.width, steps.downscaled.height));
  CheckSomethingCounts(view, image);
  ViewPhotograph result;
  result.work_bytes = most_bytes - BytesOf(image);
  result.camera = steps.downscaled;
  result.image = std::move(image);
  return result;
}

PredictedPhotograph PredictPhotograph(const View& view, const PhotographRule& rule) {
  ImageSize size = ReadImageSize(view.image_path);
  if (OrientationFor(view, size) != 1) std::swap(size.width, size.height);
  const CameraSteps steps = StepsFrom(view, size, rule);
  const Camera& camera = steps.downscaled;
  const bool may_have_mask = rule.alpha_is_mask || !view.mask_path.empty();
  return {.camera = camera,
          .bytes = (kImageBytes + (may_have_mask ? 1 : 0) + AlphaBytes(rule)) * camera.pixels(),
          .work_bytes = MostWorkBytes(view, steps, rule)};
}

double ExpectedBytes(const View& view, const PhotographRule& rule) {
  const Camera camera = UndistortedCamera(view, view.camera);
  const ImageSize size = DownscaledSize({camera.width, camera.height}, rule.downscale);
  return kImageBytes * size.pixels();
}

void LoadPhotographs(const PhotographRule& rule, double budget_bytes, Scene* scene) {
  double most = 1;  // upper bound before any image is decoded
  for (const View& view : scene->views) most = std::max(most, ExpectedBytes(view, rule));
  const auto views = static_cast<Index>(scene->views.size());
  const std::vector<View> in_files = scene->views;
  std::vector<PhotographSource> sources(scene->views.size());
  std::atomic<double> all_bytes = 0;
  const auto load = [&](Index i) {
    const auto v = static_cast<std::size_t>(i);
    View& view = scene->views[v];
    const bool is_read = all_bytes <= budget_bytes;
    ViewPhotograph photograph;
    PredictedPhotograph foreseen;
    if (is_read) {
      photograph = ReadPhotograph(in_files[v], rule);
      foreseen = {photograph.camera, BytesOf(photograph.image), photograph.work_bytes};
    } else {
      foreseen = PredictPhotograph(in_files[v], rule);
    }
    view.camera = foreseen.camera;
    if (!view.distortion.is_none()) view.bent = {in_files[v].camera, std::exchange(view.distortion, {})};
    sources[v] = {
        .decode = [in_file = in_files[v], rule, camera = view.camera] { return ReadAgain(in_file, rule, camera); },
        .bytes = foreseen.bytes,
        .work_bytes = foreseen.work_bytes};
    const double so_far = all_bytes.fetch_add(foreseen.bytes) + foreseen.bytes;
    if (is_read && so_far <= budget_bytes) view.image = std::move(photograph.image);
  };
  // The number decoded at a time is limited by the budget.
  const double together = budget_bytes / (3 * most);
  const Index at_once = together < NumThreads() ? std::max<Index>(1, static_cast<Index>(together)) : views;
  for (Index begin = 0; begin < views; begin += at_once) {
    ParallelFor(std::min(at_once, views - begin), 1, [&](Index i) { load(begin + i); });
  }
  if (all_bytes <= budget_bytes) return;
  CheckBudget(budget_bytes, scene->views);
  scene->photographs = std::make_shared<PhotographStore>(budget_bytes);
  for (std::size_t v = 0; v < sources.size(); ++v) {
    View& view = scene->views[v];
    view.stored = std::make_shared<const StoredPhotograph>(scene->photographs, std::move(sources[v]));
    if (!view.image.empty()) scene->photographs->Offer(view.stored->number(), std::exchange(view.image, Image()));
  }
  scene->notes.push_back(fmt::format(
      "{} photographs take {:.0f} MiB, but at most {:.0f} MiB stay in memory; the others are decoded on demand", views,
      all_bytes / kMib, budget_bytes / kMib));
}

namespace fs = std::filesystem;

void FindMasks(const std::string& scene_folder, Scene* scene) {
  std::string folder;
  for (const char* name : {"mask", "masks"}) {
    if (FolderExists((fs::path(scene_folder) / name).string())) folder = name;
  }
  for (View& view : scene->views) {
    if (folder.empty() || !view.mask_path.empty()) continue;
    const fs::path beside = fs::path(scene_folder) / folder / view.name;
    for (const fs::path& path : {fs::path(beside.string() + ".png"), fs::path(beside.string() + ".mask.png"),
                                 fs::path(beside).replace_extension(".png")}) {
      if (!FileExists(path.string())) continue;
      view.mask_path = path.string();
      break;
    }
  }
  const auto masked = std::ranges::count_if(scene->views, [](const View& view) { return !view.mask_path.empty(); });
  if (masked > 0) {
    scene->notes.push_back(
        fmt::format("{} of {} images have a mask; black pixels of a mask are neither trained on nor "
                    "measured",
                    masked, scene->views.size()));
  } else if (!folder.empty()) {
    scene->notes.push_back(
        fmt::format("{}/ has no mask with the name of an image, such as {}/{}.png: images are used without masks",
                    folder, folder, scene->views.front().name));
  }
}

double ApplyMask(const std::string& mask_path, Image* photograph) {
  if (!FileExists(mask_path)) {
    Fail(kNotFound, "{}: no such mask, but the scene names it; add it, or remove its name from the scene", mask_path);
  }
  double samples = 0;
  const Image mask = LoadImage(mask_path, {0, 0, 0}, &samples);
  const double across = static_cast<double>(mask.width) / photograph->width;
  const double down = static_cast<double>(mask.height) / photograph->height;
  if (std::abs(across * photograph->height - mask.height) > 1 && std::abs(mask.width - down * photograph->width) > 1) {
    Fail(kBadFile,
         "{}: a mask of {} x {} pixels for an image of {} x {}, another aspect ratio; make it of the image's size",
         mask_path, mask.width, mask.height, photograph->width, photograph->height);
  }
  if (photograph->mask.empty()) photograph->mask.assign(photograph->num_pixels(), 1);
  const auto nearest = [](int i, double scale, int size) {
    return std::min(static_cast<int>((i + 0.5) * scale), size - 1);
  };
  std::size_t pixel = 0;
  for (int y = 0; y < photograph->height; ++y) {
    const std::size_t row =
        static_cast<std::size_t>(nearest(y, down, mask.height)) * static_cast<std::size_t>(mask.width);
    for (int x = 0; x < photograph->width; ++x, ++pixel) {
      const std::size_t at = row + static_cast<std::size_t>(nearest(x, across, mask.width));
      const bool is_black = mask.plane(0)[at] + mask.plane(1)[at] + mask.plane(2)[at] == 0;
      if (is_black) photograph->mask[pixel] = 0;
    }
  }
  if (UnmaskedPixels(*photograph) == 0) {
    Fail(kBadFile,
         "{}: excludes all pixels of its image; the pixels to train on must "
         "be "
         "white",
         mask_path);
  }
  return samples + static_cast<double>(sizeof(float) * mask.rgb.size() + mask.mask.size());
}

}  // namespace vesta::gs
