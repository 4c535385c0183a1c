// The codecs behind image.h.
#pragma once

#include <string>
#include <string_view>

#include "splatting/io/images/interleaved.h"

namespace vesta::gs {

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
