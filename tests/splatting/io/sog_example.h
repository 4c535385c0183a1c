// SPDX-License-Identifier: Apache-2.0
// The files of a .sog with two Gaussians of SH degree 1, as another program could write them. Tests change some.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "splatting/io/bytes/zip.h"
#include "tests/splatting/io/test_images.h"

namespace vesta::gs {

struct SogExample {
  nlohmann::json meta = nlohmann::json::parse(R"({
    "version": 2, "count": 2,
    "means": {"mins": [-1, 0, 0], "maxs": [1, 0, 2], "files": ["means_l.webp", "means_u.webp"]},
    "scales": {"codebook": [-6, -5], "files": ["scales.webp"]},
    "quats": {"files": ["quats.webp"]},
    "sh0": {"codebook": [0.5, -0.5], "files": ["sh0.webp"]},
    "shN": {"count": 66, "bands": 1, "codebook": [0, 0.25, -0.25], "files": ["shN_centroids.webp", "shN_labels.webp"]}
  })");
  // Images of two pixels.
  std::vector<std::uint8_t> lower = {0, 0, 0, 0x34, 0, 0xff}, upper = {0, 0, 0, 0x12, 0, 0xff},
                            scales = {0, 0, 0, 1, 1, 1}, labels = {65, 0, 0, 0, 0, 0};
  std::vector<std::uint8_t> rotations = {128, 128, 128, 252, 153, 102, 128, 253}, colors = {0, 0, 1, 128, 1, 1, 0, 51};

  // Rows of 64 entries with three pixels each. Entry 65 is 0.25 in all numbers, the others are -0.25.
  static std::string Centroids() {
    std::vector<std::uint8_t> bytes(2 * 64 * 3 * 3, 2);
    for (std::size_t k = 0; k < 9; ++k) bytes[(64 + 1) * 9 + k] = 1;
    return EncodeWebp(64 * 3, 2, 3, bytes);
  }
  std::vector<ZipEntry> Entries() const {
    return {{"means_l.webp", EncodeWebp(2, 1, 3, lower)},     {"means_u.webp", EncodeWebp(2, 1, 3, upper)},
            {"quats.webp", EncodeWebp(2, 1, 4, rotations)},   {"scales.webp", EncodeWebp(2, 1, 3, scales)},
            {"sh0.webp", EncodeWebp(2, 1, 4, colors)},        {"shN_centroids.webp", Centroids()},
            {"shN_labels.webp", EncodeWebp(2, 1, 3, labels)}, {"meta.json", meta.dump()}};
  }
};

}  // namespace vesta::gs
