// SPDX-License-Identifier: Apache-2.0
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

// Tags as libtiff names them; `bytes` interleaved, samples of 16 bits in the machine's order. samples: 1 grey, 3 RGB,
// one more has `extra_kind` (EXTRASAMPLE_*). With tile > 0 it is in tiles of that side.
struct TiffSource {
  int width = 0, height = 0, samples = 3, bits = 8;
  int compression = 1, photometric = 2, sample_format = 1, extra_kind = -1, tile = 0;
  bool separate_planes = false;
  std::vector<std::uint8_t> bytes;
};
std::string EncodeTiff(const TiffSource& source);

// Without loss; channels: 3 RGB, 4 RGBA.
std::string EncodeWebp(int width, int height, int channels, const std::vector<std::uint8_t>& bytes);

// A smooth colourful JPEG.
std::string ExampleJpeg(int width, int height, bool progressive = false);

// The JPEG with an EXIF segment that states the orientation.
std::string WithOrientation(const std::string& jpeg, int orientation, bool big_endian = false);

}  // namespace vesta::gs
