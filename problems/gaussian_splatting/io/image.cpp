#include "problems/gaussian_splatting/io/image.h"

#include <png.h>

#include <cstdint>
#include <vector>

#include "kernels/core/atomic_file.h"
#include "kernels/core/check.h"
#include "problems/gaussian_splatting/io/byte_reader.h"
#include "problems/gaussian_splatting/io/image_codecs.h"

namespace vesta::gs {

namespace {

Image Decode(const std::string& path, const std::array<float, 3>& background, bool size_only) {
  const std::string bytes = ReadFile(path);
  if (bytes.starts_with("\xff\xd8\xff")) return DecodeJpeg(path, bytes, size_only);
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return DecodePng(path, bytes, background, size_only);
  Fail("{}: not a JPEG or PNG image; convert it, or remove it from the scene", path);
}

}  // namespace

Image LoadImage(const std::string& path, const std::array<float, 3>& background) {
  return Decode(path, background, false);
}

ImageSize ReadImageSize(const std::string& path) {
  const Image image = Decode(path, {}, true);
  return {image.width, image.height};
}

void CheckImageSize(const std::string& path, std::size_t num_bytes, ImageSize size) {
  constexpr double kMaxPixels = 1 << 28;
  // Deflate packs at most 1032 bytes into one, so 8256 black and white pixels; a JPEG needs more.
  constexpr double kMaxPixelsPerByte = 8320;
  const double pixels = static_cast<double>(size.width) * size.height;
  if (size.width <= 0 || size.height <= 0) FailDamagedImage(path, "it has no pixels");
  if (pixels > kMaxPixels) {
    Fail("{}: {} x {} pixels are more than the 268 million that are read; downscale it", path, size.width, size.height);
  }
  if (pixels > kMaxPixelsPerByte * static_cast<double>(num_bytes)) {
    FailDamagedImage(path, "it is too short for the size in its header");
  }
}

void FailDamagedImage(const std::string& path, const char* message) {
  Fail("{}: cut short or damaged ({}); copy or export it again", path, message);
}

std::vector<std::uint8_t> InterleavedBytes(const Image& image) {
  const std::size_t pixels = image.num_pixels();
  std::vector<std::uint8_t> interleaved(3 * pixels);
  for (int c = 0; c < 3; ++c) {
    const float* plane = image.plane(c);
    for (std::size_t i = 0; i < pixels; ++i) interleaved[3 * i + static_cast<std::size_t>(c)] = QuantizeColor(plane[i]);
  }
  return interleaved;
}

void SavePng(const std::string& path, const Image& image) {
  VESTA_CHECK(image.width > 0 && image.height > 0, "{}: an image without pixels", path);
  const std::vector<std::uint8_t> interleaved = InterleavedBytes(image);
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, interleaved.data(), 0, nullptr) == 0) {
    Fail("{}: cannot be encoded as PNG: {}", path, png.message);
  }
  WriteFileAtomically(path, std::string_view(bytes).substr(0, size));
}

}  // namespace vesta::gs
