// Encoders of image files that the library itself never writes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace vesta::gs {

// `color_type` of libpng (PNG_COLOR_TYPE_*); `rows` packed as the format has them. A palette image takes its three
// colours from PaletteColors(), the third half transparent.
struct PngSource {
  int width = 0, height = 0, color_type = 0, bit_depth = 8;
  bool interlaced = false;
  std::vector<std::uint8_t> bytes;
};
std::string EncodePng(const PngSource& source);
const std::uint8_t (*PaletteColors())[3];

// components: 1 grey, 3 RGB, 4 CMYK.
struct JpegSource {
  int width = 0, height = 0, components = 3;
  bool progressive = false;
  std::vector<std::uint8_t> bytes;  // interleaved
};
std::string EncodeJpeg(const JpegSource& source);

// A smooth colourful JPEG.
std::string ExampleJpeg(int width, int height, bool progressive = false);

// The JPEG with an EXIF segment that states the orientation.
std::string WithOrientation(const std::string& jpeg, int orientation, bool big_endian = false);

}  // namespace vesta::gs
