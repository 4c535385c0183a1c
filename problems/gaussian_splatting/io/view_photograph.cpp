#include "problems/gaussian_splatting/io/view_photograph.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/io/byte_reader.h"
#include "problems/gaussian_splatting/io/exif.h"
#include "problems/gaussian_splatting/io/image.h"
#include "problems/gaussian_splatting/io/masks.h"
#include "problems/gaussian_splatting/model/undistort.h"

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

// As the camera has it. Most programs find cameras of images as they are stored; those that turn them upright first, as
// their EXIF says, leave a camera of swapped sides.
// most_bytes: gets the most that was held.
Image LoadTurned(const View& view, const std::array<float, 3>& background, double* most_bytes) {
  const Camera& camera = view.camera;
  double samples = 0;
  Image image = LoadImage(view.image_path, background, &samples);
  *most_bytes = BytesOf(image) + samples;
  if (HasShapeOf(camera, {image.width, image.height})) return image;
  if (HasShapeOf(camera, {image.height, image.width})) {
    *most_bytes = std::max(*most_bytes, 2 * BytesOf(image));
    const int orientation = ExifOrientation(ReadFile(view.image_path));
    image = TurnedUpright(image, orientation);
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

}  // namespace

double BytesOf(const Image& image) { return static_cast<double>(sizeof(float) * image.rgb.size() + image.mask.size()); }

ViewPhotograph ReadPhotograph(const View& view, const PhotographRule& rule) {
  double most_bytes = 0;
  Image image = LoadTurned(view, rule.background, &most_bytes);
  const auto replace_by = [&](Image made) {
    most_bytes = std::max(most_bytes, BytesOf(image) + BytesOf(made));
    image = std::move(made);
  };
  if (!rule.alpha_is_mask) image.mask = std::vector<std::uint8_t>();
  if (!view.mask_path.empty()) {
    const double bytes = ApplyMask(view.mask_path, &image);
    most_bytes = std::max(most_bytes, bytes + BytesOf(image));
  }
  Camera camera = ResizeCamera(view.camera, image.width, image.height);
  if (!view.distortion.is_none()) {
    const Camera pinhole = UndistortedCamera(view, camera);
    replace_by(UndistortImage(image, camera, view.distortion, pinhole));
    camera = pinhole;
  }
  const ImageSize size = DownscaledSize({image.width, image.height}, rule.downscale);
  if (rule.downscale > 1) replace_by(ResizeArea(image, size.width, size.height));
  CheckSomethingCounts(view, image);
  ViewPhotograph result;
  result.work_bytes = most_bytes - BytesOf(image);
  result.camera = ResizeCamera(camera, size.width, size.height);
  result.image = std::move(image);
  return result;
}

double ExpectedBytes(const View& view, const PhotographRule& rule) {
  const Camera camera = UndistortedCamera(view, view.camera);
  const ImageSize size = DownscaledSize({camera.width, camera.height}, rule.downscale);
  return 3.0 * sizeof(float) * size.width * size.height;
}

}  // namespace vesta::gs
