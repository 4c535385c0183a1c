// SPDX-License-Identifier: Apache-2.0
// Small .ksplat files, byte by byte (splatting/io/splats/ksplat.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <string>
#include <vector>

namespace vesta::gs {

// Appends values of type T.
template <class T>
void AppendValues(std::string* bytes, std::initializer_list<T> values) {
  for (const T value : values) {
    std::string word(sizeof(value), '\0');
    std::memcpy(word.data(), &value, sizeof(value));
    *bytes += word;
  }
}

// Bytes of the header of a file and of a section, and how many of them are in use, from the first on.
inline constexpr std::size_t kKsplatHeader = 4096, kKsplatHeaderUsed = 44;
inline constexpr std::size_t kKsplatSectionHeader = 1024, kKsplatSectionUsed = 42;

// Half floats of 1, 0.5, -0.25 and 0, and of the smallest positive number.
inline constexpr std::uint16_t kOne = 0x3c00, kHalf = 0x3800, kMinusQuarter = 0xb400, kLeast = 1;

// A section with two Gaussians, the first in a full bucket of one, the second in another bucket. SH value k of a
// Gaussian is 1 for odd k and 0.5 for even k; at level 2, the bytes 255 and 0.
struct KsplatSection {
  std::uint32_t count = 2, capacity = 2, bucket_size = 1, buckets = 2, full = 1, other = 1, other_size = 1;
  std::uint16_t bucket_bytes = 12, degree = 0;

  std::string HeaderBytes(int level) const {
    std::string bytes;
    if (level == 0) {
      AppendValues<std::uint32_t>(&bytes, {count, capacity, 0, 0, 0, 0, 0, 0, 0, 0});
    } else {
      AppendValues<std::uint32_t>(&bytes, {count, capacity, bucket_size, buckets});
      AppendValues<float>(&bytes, {8});  // side of a block
      AppendValues<std::uint16_t>(&bytes, {bucket_bytes, 0});
      AppendValues<std::uint32_t>(&bytes, {1000, 0, full, other});  // 1000: the middle of a mean
    }
    AppendValues<std::uint16_t>(&bytes, {degree});
    bytes.resize(kKsplatSectionHeader);
    return bytes;
  }

  std::string DataBytes(int level) const {
    std::string bytes;
    if (level > 0) {
      AppendValues<std::uint32_t>(&bytes, {other_size});
      AppendValues<float>(&bytes, {1, 2, 3, 11, 12, 13});  // the centres
    }
    for (std::uint32_t i = 0; i < capacity; ++i) {
      if (level == 0) {
        AppendValues<float>(&bytes, {1, 2, 3, 1, 0.5f, 0, 0.5f, 0, 0, -0.25f});
      } else {
        AppendValues<std::uint16_t>(&bytes, {1000, 1250, 0, kOne, kHalf, kLeast, kHalf, 0, 0, kMinusQuarter});
      }
      AppendValues<std::uint8_t>(&bytes, {255, 0, 51, 128});
      for (int k = 0; k < 3 * (degree * degree + 2 * degree); ++k) {
        if (level == 0) AppendValues<float>(&bytes, {k % 2 == 1 ? 1.0f : 0.5f});
        if (level == 1) AppendValues<std::uint16_t>(&bytes, {k % 2 == 1 ? kOne : kHalf});
        if (level == 2) AppendValues<std::uint8_t>(&bytes, {static_cast<std::uint8_t>(k % 2 == 1 ? 255 : 0)});
      }
    }
    return bytes;
  }
};

struct KsplatParts {
  int level = 1;
  std::uint8_t minor = 1;
  std::uint32_t num_sections = 1, count = 2;
  float min_sh = 0.5f, max_sh = 1;
  std::vector<KsplatSection> sections = {{}};

  std::string File() const {
    std::string bytes, headers, data;
    AppendValues<std::uint8_t>(&bytes, {0, minor, 0, 0});
    AppendValues<std::uint32_t>(&bytes, {num_sections, num_sections, count, count});
    AppendValues<std::uint16_t>(&bytes, {static_cast<std::uint16_t>(level), 0});
    AppendValues<float>(&bytes, {0, 0, 0, min_sh, max_sh});
    bytes.resize(kKsplatHeader);
    for (const KsplatSection& section : sections) {
      headers += section.HeaderBytes(level);
      data += section.DataBytes(level);
    }
    return bytes + headers + data;
  }
};

}  // namespace vesta::gs
