// SPDX-License-Identifier: Apache-2.0
// The files of .spz: a header, six arrays of quantised values, and vesta's comments (SplatComments). Versions 1 to 3
// are a gzip archive. Version 4 has a header that is not compressed, and a zstd stream for each array.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

inline constexpr std::uint32_t kLatestSpz = 4;
inline constexpr int kMaxSpzDegree = 4;

// The arrays, in the order of the file.
enum SpzArray { kSpzMean, kSpzOpacity, kSpzColor, kSpzScale, kSpzRotation, kSpzSh, kNumSpzArrays };

struct SpzFile {
  std::uint32_t version = kLatestSpz;
  Index count = 0;
  int sh_degree = 0;
  int fraction_bits = 0;  // of the fixed-point means
  bool antialiased = false;
  std::vector<std::string> comments;
  std::array<std::vector<std::uint8_t>, kNumSpzArrays> arrays;  // count * Width(array) bytes each

  // Bytes per Gaussian.
  Index Width(int array) const;
};

// bytes: the content of the file. Throws Error, in one line with the file and the problem, if the file is damaged or
// not supported. The sizes in the header are checked against the file before memory is allocated, or memory grows with
// the decompressed bytes.
SpzFile ReadSpzFile(const std::string& path, std::string_view bytes);

// The content of the file. The version must be 2, 3 or 4.
std::string SpzFileBytes(const SpzFile& file);

}  // namespace vesta::gs
