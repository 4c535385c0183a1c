// The codecs behind image.h.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "problems/gaussian_splatting/io/image.h"

namespace vesta::gs {

// `bytes` is the file's content; `path` is for messages. With size_only the image stays without pixels.
Image DecodeJpeg(const std::string& path, std::string_view bytes, bool size_only);
Image DecodePng(const std::string& path, std::string_view bytes, const std::array<float, 3>& background,
                bool size_only);

// Rows of interleaved RGB, 8 bits each, as encoders take them.
std::vector<std::uint8_t> InterleavedBytes(const Image& image);

// Throws Error unless a file of so many bytes can hold so many pixels: a damaged header must not allocate gigabytes.
void CheckImageSize(const std::string& path, std::size_t num_bytes, ImageSize size);

[[noreturn]] void FailDamagedImage(const std::string& path, const char* message);

}  // namespace vesta::gs
