#include "splatting/io/scenes/view_photograph.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/scene/undistort.h"
#include "splatting/io/bytes/byte_reader.h"
#include "splatting/io/images/exif.h"
#include "splatting/io/images/image.h"
#include "splatting/io/scenes/masks.h"

namespace vesta::gs {
namespace {

// The pinhole that will stand for the view's camera, before --downscale.
Camera UndistortedCamera(const View& view, const Camera& camera) {
  const std::optional<Camera> pinhole = PinholeOf(camera, view.distortion);
  if (pinhole) return *pinhole;
  Fail(
      "{}: the distortion of its camera leaves less than a fifth of the image's width or height to see undistorted; "
      "calibrate the camera again, or remove its images from the model",
      view.image_path);
}

// Whether an image of that size can be the camera's, but for the scale.
bool HasShapeOf(const Camera& camera, ImageSize size) {
  const double height_at_width = static_cast<double>(camera.height) * size.width / camera.width;
  const double width_at_height = static_cast<double>(camera.width) * size.height / camera.height;
  return std::abs(height_at_width - size.height) <= 1 || std::abs(width_at_height - size.width) <= 1;
}

// How an image of that size has to be turned to be the camera's: 1 where it is as the camera has it, else what its EXIF
// says. Most programs find cameras of images as they are stored; those that turn them upright first leave a camera of
// swapped sides.
int OrientationFor(const View& view, ImageSize size) {
  constexpr int kFirstThatSwapsSides = 5;
  const Camera& camera = view.camera;
  if (HasShapeOf(camera, size)) return 1;
  if (HasShapeOf(camera, {size.height, size.width})) {
    const int orientation = ExifOrientation(ReadFile(view.image_path));
    if (orientation >= kFirstThatSwapsSides) return orientation;
  }
  Fail(
      "{}: {} x {} pixels, but its camera has {} x {}, another aspect ratio; use the images the model was made "
      "from",
      view.image_path, size.width, size.height, camera.width, camera.height);
}

// most_bytes: gets the most that was held.
Image LoadTurned(const View& view, const std::array<float, 3>& background, double* most_bytes) {
  double samples = 0;
  Image image = LoadImage(view.image_path, background, &samples);
  *most_bytes = BytesOf(image) + samples;
  const int orientation = OrientationFor(view, {image.width, image.height});
  if (orientation == 1) return image;
  *most_bytes = std::max(*most_bytes, 2 * BytesOf(image));
  return TurnedUpright(image, orientation);
}

// From the photograph in its file, turned, to the one that is trained on.
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

// What making it will take at most beside the result: the decoder's samples, four of two bytes, and the planes made of
// them; where planes are made of planes or turned, or have a mask, these.
double MostWorkBytes(const View& view, const CameraSteps& steps, const PhotographRule& rule) {
  constexpr double kMostSampleBytes = 8, kMaskedBytes = kImageBytes + 1;
  const double in_file = steps.in_file.pixels(), undistorted = steps.undistorted.pixels(),
               result = steps.downscaled.pixels();
  double most = (kMaskedBytes + kMostSampleBytes) * in_file;
  most = std::max(most, 2 * kMaskedBytes * in_file);
  if (!view.mask_path.empty()) most = std::max(most, (2 * kMaskedBytes + kMostSampleBytes) * in_file);
  if (!view.distortion.is_none()) most = std::max(most, kMaskedBytes * (in_file + undistorted));
  if (rule.downscale > 1) most = std::max(most, kMaskedBytes * (undistorted + result));
  return most - kImageBytes * result;
}

void CheckSomethingCounts(const View& view, const Image& image) {
  if (CountedPixels(image) > 0) return;
  Fail("{}: by its mask or its alpha nothing of it would be trained on or measured; remove it from the model",
       view.image_path);
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
  if (!rule.alpha_is_mask) image.mask = std::vector<std::uint8_t>();
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

ForeseenPhotograph ForeseePhotograph(const View& view, const PhotographRule& rule) {
  ImageSize size = ReadImageSize(view.image_path);
  if (OrientationFor(view, size) != 1) std::swap(size.width, size.height);
  const CameraSteps steps = StepsFrom(view, size, rule);
  const Camera& camera = steps.downscaled;
  const bool may_have_mask = rule.alpha_is_mask || !view.mask_path.empty();
  return {.camera = camera,
          .bytes = (kImageBytes + (may_have_mask ? 1 : 0)) * camera.pixels(),
          .work_bytes = MostWorkBytes(view, steps, rule)};
}

double ExpectedBytes(const View& view, const PhotographRule& rule) {
  const Camera camera = UndistortedCamera(view, view.camera);
  const ImageSize size = DownscaledSize({camera.width, camera.height}, rule.downscale);
  return kImageBytes * size.pixels();
}

}  // namespace vesta::gs
