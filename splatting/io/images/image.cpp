#include "splatting/io/images/image.h"

#include <png.h>

#include <cstdint>
#include <vector>

#include "kernels/core/atomic_file.h"
#include "kernels/core/check.h"
#include "splatting/io/bytes/byte_reader.h"
#include "splatting/io/images/image_codecs.h"

namespace vesta::gs {

namespace {

using Decoder = InterleavedImage (*)(const std::string& path, std::string_view bytes, bool size_only);

// By the first bytes of the file; nullptr where none reads it.
Decoder DecoderOf(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\xff\xd8\xff")) return DecodeJpeg;
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return DecodePng;
  if (bytes.starts_with("RIFF") && bytes.substr(0, 12).ends_with("WEBP")) return DecodeWebp;
  for (const std::string_view tiff : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
    if (bytes.starts_with(tiff)) return DecodeTiff;
  }
  return nullptr;
}

InterleavedImage Decode(const std::string& path, bool size_only) {
  const std::string bytes = ReadFile(path);
  const Decoder decoder = DecoderOf(bytes);
  if (decoder == nullptr) {
    Fail("{}: not a JPEG, PNG, TIFF or WebP image; convert it, or remove it from the scene", path);
  }
  return decoder(path, bytes, size_only);
}

}  // namespace

Image LoadImage(const std::string& path, const std::array<float, 3>& background, double* work_bytes) {
  const InterleavedImage samples = Decode(path, false);
  if (work_bytes) *work_bytes = static_cast<double>(samples.bytes.size());
  return ToPlanes(samples, background);
}

ImageSize ReadImageSize(const std::string& path) { return Decode(path, true).size; }

void CheckImageSize(const std::string& path, std::size_t num_bytes, ImageSize size) {
  constexpr double kMaxPixels = 1 << 28;
  // Deflate packs at most 1032 bytes into one, so 8256 black and white pixels; a JPEG needs more.
  constexpr double kMaxPixelsPerByte = 8320;
  const double pixels = size.pixels();
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
