// SPDX-License-Identifier: Apache-2.0
// Encoders for formats that the library only reads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace vesta::gs {

// `color_type` of libpng (PNG_COLOR_TYPE_*), `rows` packed as in the file. A palette has the three colours of
// PaletteColors(), the third half transparent.
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

// Tags as in libtiff; `bytes` interleaved, 16-bit samples in native order. samples: 1 grey, 3 RGB; an additional one
// has `extra_kind` (EXTRASAMPLE_*). tile: side of the tiles, 0 for strips.
struct TiffSource {
  int width = 0, height = 0, samples = 3, bits = 8;
  int compression = 1, photometric = 2, sample_format = 1, extra_kind = -1, tile = 0;
  bool separate_planes = false;
  std::vector<std::uint8_t> bytes;
};
std::string EncodeTiff(const TiffSource& source);

// Lossless. channels: 3 RGB, 4 RGBA.
std::string EncodeWebp(int width, int height, int channels, const std::vector<std::uint8_t>& bytes);

// A smooth colour image as JPEG.
std::string ExampleJpeg(int width, int height, bool progressive = false);

// With an EXIF segment for the orientation.
std::string WithOrientation(const std::string& jpeg, int orientation, bool big_endian = false);
// With an EXIF segment for the camera's model and focal length, and with a latitude if has_position.
std::string WithCamera(const std::string& jpeg, const std::string& model, unsigned focal_length, bool has_position,
                       bool big_endian = false);

}  // namespace vesta::gs
