// SPDX-License-Identifier: Apache-2.0
// Zstandard streams (RFC 8878) of one frame.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

std::string CompressZstd(std::string_view bytes);

// Decompresses a stream that must have `size` bytes. Memory grows with the decompressed bytes, because a damaged file
// may state any size. Throws Error, naming the file, if the stream is damaged, or shorter or longer than `size`.
std::vector<std::uint8_t> DecompressZstd(const std::string& path, std::string_view stream, Index size);

}  // namespace vesta::gs
