// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>

#include <cstdint>

#include "splatting/io/images/image_file.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {
namespace {

// A 32-bit big-endian number.
std::uint32_t BigEndian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(bytes[at + k]);
  return value;
}

// Corrects the checksums of PNG chunks, at which almost every mutation would fail.
std::string WithChecksums(std::string_view bytes) {
  constexpr std::size_t kSignature = 8, kAround = 12;  // length, type and checksum of a chunk
  std::string png(bytes);
  if (!png.starts_with("\x89PNG")) return png;
  for (std::size_t at = kSignature; at + kAround <= png.size();) {
    const std::size_t length = BigEndian(png, at);
    if (length > png.size() - at - kAround) break;
    const auto* chunk = reinterpret_cast<const unsigned char*>(png.data()) + at + 4;
    const auto checksum = static_cast<std::uint32_t>(crc32_z(0, chunk, length + 4));
    for (std::size_t k = 0; k < 4; ++k) png[at + 8 + length + k] = static_cast<char>(checksum >> (24 - 8 * k));
    at += length + kAround;
  }
  return png;
}

}  // namespace

void FuzzImage(std::string_view bytes) {
  // Larger images take long to decode. CheckImageSize, which limits the size in headers, runs for any size.
  constexpr std::int64_t kMostPixels = 1 << 20;
  static const ScratchFolder folder;
  const int orientation = gs::ExifOrientation(bytes);
  Promise(orientation >= 1 && orientation <= 8, "an invalid orientation");
  Promise(gs::ReadExifOrigin(bytes).camera.size() <= 260, "a long camera");
  const std::string path = folder.Write("image", WithChecksums(bytes));
  gs::ImageSize size;
  if (!Reads(path, [&] { size = gs::ReadImageSize(path); })) return;
  Promise(size.width > 0 && size.height > 0, "an image without pixels");
  if (std::int64_t{size.width} * size.height > kMostPixels) return;
  gs::Image image;
  if (!Reads(path, [&] { image = gs::LoadImage(path, {0.2f, 0.5f, 1.0f}); })) return;
  Promise(image.width == size.width && image.height == size.height, "the image size differs from the header");
  Promise(image.rgb.size() == 3 * image.num_pixels(), "a wrong number of values");
  for (const float value : image.rgb) Promise(value >= 0 && value <= 1, "a colour outside 0..1");
}

}  // namespace vesta::fuzz
