// SPDX-License-Identifier: Apache-2.0
// Palettes of numbers and of vectors, by k-means clustering (Lloyd's algorithm). The results are deterministic.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

// 256 numbers in ascending order.
using NumberPalette = std::array<float, 256>;

// A palette for these finite values, at least one, with a small sum of squared errors. Up to 256 different values are
// kept exactly. If zero occurs, it is kept exactly.
NumberPalette MakeNumberPalette(std::vector<float> values);

// Index of the entry nearest to the value.
std::uint8_t NearestEntry(const NumberPalette& palette, float value);

struct VectorPalette {
  std::vector<float> entries;         // row by row
  std::vector<std::uint16_t> labels;  // per vector: index of its entry
};

// A palette of `count` entries, at most 65536, for vectors of `dimension` numbers, stored row by row.
// Large palettes are divided recursively: up to 256 cells share the entries, and each cell is clustered on its own. A
// vector is compared with a few hundred entries per level instead of with all, so the time is proportional to the
// number of vectors. With at least as many entries as vectors, each vector has its own entry.
VectorPalette MakeVectorPalette(const std::vector<float>& vectors, Index dimension, Index count);

}  // namespace vesta::gs
