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
  kStraight,       // colours are those of the thing
  kPremultiplied,  // colours are multiplied by it
};

struct InterleavedImage {
  ImageSize size;
  std::size_t samples = 3;       // a pixel; those beyond colour and alpha are passed over
  std::size_t sample_bytes = 1;  // 1 or 2, then in the machine's order
  Alpha alpha = Alpha::kNone;    // of the sample after the colours
  std::vector<unsigned char> bytes;

  // Room for all samples; what they are does not change it.
  void Allocate() { bytes.resize(num_pixels() * samples * sample_bytes); }
  std::size_t row_bytes() const { return static_cast<std::size_t>(size.width) * samples * sample_bytes; }
  std::size_t num_pixels() const {
    return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  }
  // 1 (grey) or 3.
  std::size_t colors() const { return samples >= 3 ? 3 : 1; }
};

// Values in 0..1. Alpha is composited over `background`, and the mask has the pixels that are opaque; it is empty
// where all are.
Image ToPlanes(const InterleavedImage& source, const std::array<float, 3>& background);

// Rows of interleaved RGB, 8 bits each.
std::vector<std::uint8_t> InterleavedBytes(const Image& image);

// Each gives the samples of a file, or with size_only the size alone. `bytes` is the file's content; `path` is for
// messages. Throws Error where the file is damaged, cut short, or of a kind that is not read.
InterleavedImage DecodeJpeg(const std::string& path, std::string_view bytes, bool size_only);
InterleavedImage DecodePng(const std::string& path, std::string_view bytes, bool size_only);
InterleavedImage DecodeTiff(const std::string& path, std::string_view bytes, bool size_only);
InterleavedImage DecodeWebp(const std::string& path, std::string_view bytes, bool size_only);

// Throws Error unless a file of so many bytes can hold so many pixels: a damaged header must not allocate gigabytes.
void CheckImageSize(const std::string& path, std::size_t num_bytes, ImageSize size);

[[noreturn]] void FailDamagedImage(const std::string& path, const char* message);

}  // namespace vesta::gs
