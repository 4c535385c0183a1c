// SPDX-License-Identifier: Apache-2.0
// Image codecs and their interleaved samples.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::gs {

enum class Alpha {
  kNone,
  kStraight,       // colours not multiplied by alpha
  kPremultiplied,  // colours multiplied by alpha
};

// Row by row; the samples of a pixel are adjacent.
struct InterleavedImage {
  ImageSize size;
  std::size_t samples = 3;       // per pixel; samples after colour and alpha are ignored
  std::size_t sample_bytes = 1;  // 1, or 2 in the machine's byte order
  Alpha alpha = Alpha::kNone;    // kind of the sample after the colours
  std::vector<unsigned char> bytes;

  // Does not change existing samples.
  void Allocate() { bytes.resize(num_pixels() * samples * sample_bytes); }
  std::size_t row_bytes() const { return static_cast<std::size_t>(size.width) * samples * sample_bytes; }
  std::size_t num_pixels() const {
    return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  }
  // 1 (grey) or 3.
  std::size_t colors() const { return samples >= 3 ? 3 : 1; }
};

// Converts to three planes with values in 0..1. Pixels that are not opaque are composited over `background` and masked.
// The mask is empty if all pixels are opaque.
Image ToPlanes(const InterleavedImage& source, const std::array<float, 3>& background);

// Interleaved RGB, row by row, 8 bits per sample.
std::vector<std::uint8_t> InterleavedBytes(const Image& image);

// Decode a file; with size_only, read only its size. `bytes`: content of the file; `path`: for messages. Throw Error if
// the file is damaged, truncated or of an unsupported kind.
InterleavedImage DecodeJpeg(const std::string& path, std::string_view bytes, bool size_only);
InterleavedImage DecodePng(const std::string& path, std::string_view bytes, bool size_only);
InterleavedImage DecodeTiff(const std::string& path, std::string_view bytes, bool size_only);
InterleavedImage DecodeWebp(const std::string& path, std::string_view bytes, bool size_only);

// Encodes four samples of 8 bits per pixel as WebP without loss. The colours of transparent pixels are kept too.
// `path`: for messages.
std::string EncodeLosslessWebp(const std::string& path, const InterleavedImage& image);

// Throws Error if num_bytes are too few for an image of this size, so that a damaged header cannot make the reader
// allocate gigabytes.
void CheckImageSize(const std::string& path, std::size_t num_bytes, ImageSize size);

[[noreturn]] void FailDamagedImage(const std::string& path, const char* message);

}  // namespace vesta::gs
