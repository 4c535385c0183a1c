#include "splatting/io/images/exif.h"

#include <cstddef>
#include <cstdint>

namespace vesta::gs {
namespace {

// Numbers of 2 or 4 bytes in one of the two byte orders; 0 beyond the end.
struct Bytes {
  std::string_view bytes;
  bool big_endian = true;

  std::uint32_t Number(std::size_t at, std::size_t size) const {
    if (at > bytes.size() || size > bytes.size() - at) return 0;
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < size; ++k) {
      const std::size_t from = big_endian ? at + k : at + size - 1 - k;
      value = value << 8 | static_cast<unsigned char>(bytes[from]);
    }
    return value;
  }
};

// The first directory of a TIFF header.
int OrientationOf(std::string_view tiff) {
  constexpr std::size_t kEntry = 12, kValue = 8;
  constexpr std::uint32_t kOrientation = 274, kShort = 3;
  if (!tiff.starts_with("MM") && !tiff.starts_with("II")) return 1;
  const Bytes in{tiff, tiff.starts_with("MM")};
  const std::size_t directory = in.Number(4, 4), count = in.Number(directory, 2);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t entry = directory + 2 + k * kEntry;
    if (entry + kEntry > tiff.size()) break;
    if (in.Number(entry, 2) != kOrientation || in.Number(entry + 2, 2) != kShort) continue;
    const std::uint32_t value = in.Number(entry + kValue, 2);
    return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
  }
  return 1;
}

}  // namespace

int ExifOrientation(std::string_view jpeg) {
  using std::string_view_literals::operator""sv;
  constexpr auto kExif = "Exif\0\0"sv;
  constexpr std::uint32_t kApp1 = 0xffe1, kScan = 0xffda;
  if (!jpeg.starts_with("\xff\xd8")) return 1;
  const Bytes in{jpeg};
  for (std::size_t at = 2; at + 4 <= jpeg.size();) {
    const std::uint32_t marker = in.Number(at, 2), length = in.Number(at + 2, 2);
    if (marker < 0xff00 || marker == kScan || length < 2) break;
    const std::string_view segment = jpeg.substr(at + 4, length - 2);
    if (marker == kApp1 && segment.starts_with(kExif)) return OrientationOf(segment.substr(kExif.size()));
    at += 2 + length;
  }
  return 1;
}

Image TurnedUpright(const Image& image, int orientation) {
  constexpr int kFirstSwapped = 5;
  if (orientation < kFirstSwapped) return image;
  // The pixel of the result at (x, y) is in row x or its opposite, and in column y or its opposite.
  const bool from_bottom = orientation == 6 || orientation == 7, from_right = orientation == 7 || orientation == 8;
  Image upright(image.height, image.width);
  for (int c = 0; c < 3; ++c) {
    const float* from = image.plane(c);
    float* to = upright.plane(c);
    for (int y = 0; y < upright.height; ++y) {
      const int column = from_right ? image.width - 1 - y : y;
      for (int x = 0; x < upright.width; ++x) {
        const int row = from_bottom ? image.height - 1 - x : x;
        *to++ = from[static_cast<std::ptrdiff_t>(row) * image.width + column];
      }
    }
  }
  return upright;
}

}  // namespace vesta::gs
