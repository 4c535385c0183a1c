// SPDX-License-Identifier: Apache-2.0
// Image codecs, and the interleaved samples that they read and write.
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
  kStraight,       // colours are not multiplied by alpha
  kPremultiplied,  // colours are multiplied by alpha
};

struct InterleavedImage {
  ImageSize size;
  std::size_t samples = 3;       // per pixel; samples after colour and alpha are ignored
  std::size_t sample_bytes = 1;  // 1, or 2 in the machine's byte order
  Alpha alpha = Alpha::kNone;    // kind of the sample after the colours
  std::vector<unsigned char> bytes;

  // Allocates all samples; does not change existing ones.
  void Allocate() { bytes.resize(num_pixels() * samples * sample_bytes); }
  std::size_t row_bytes() const { return static_cast<std::size_t>(size.width) * samples * sample_bytes; }
  std::size_t num_pixels() const {
    return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  }
  // 1 (grey) or 3.
  std::size_t colors() const { return samples >= 3 ? 3 : 1; }
};

// Converts to planes with values in 0..1. Alpha is composited over `background`, and the mask has the opaque pixels.
// The mask is empty if all pixels are opaque.
Image ToPlanes(const InterleavedImage& source, const std::array<float, 3>& background);

// Rows of interleaved RGB, 8 bits each.
std::vector<std::uint8_t> InterleavedBytes(const Image& image);

// Decode the samples of a file, or with size_only its size alone. `bytes`: content of the file; `path`: for messages.
// Throw Error if the file is damaged, truncated or of an unsupported kind.
InterleavedImage DecodeJpeg(const std::string& path, std::string_view bytes, bool size_only);
InterleavedImage DecodePng(const std::string& path, std::string_view bytes, bool size_only);
InterleavedImage DecodeTiff(const std::string& path, std::string_view bytes, bool size_only);
InterleavedImage DecodeWebp(const std::string& path, std::string_view bytes, bool size_only);

// Throws Error if a file of num_bytes cannot hold an image of this size, so that a damaged header cannot allocate
// gigabytes.
void CheckImageSize(const std::string& path, std::size_t num_bytes, ImageSize size);

[[noreturn]] void FailDamagedImage(const std::string& path, const char* message);

}  // namespace vesta::gs
