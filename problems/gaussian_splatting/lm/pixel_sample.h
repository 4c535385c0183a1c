// A random part of the pixels of an image, in pieces that save time.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

enum class SamplingUnit {
  // Rows of 16 pixels, as many of each tile of 16 x 16: every Gaussian keeps its share of the pixels. What is done once
  // for a splat and tile is not saved.
  kRows,
  kTiles,  // whole tiles: saves all of what is left out, but small Gaussians are in or out
};

struct PixelSample {
  std::vector<std::uint16_t> rows;  // [tiles] bit y: row y of the tile is in the sample
  // Pixels there are over those in the sample: what sums over it are to be multiplied by. Each is as likely as any.
  double scale = 1;
};

// Without replacement, about `rate` of all, within (0, 1]: a whole number of rows of each tile, or of tiles, at least
// one. The same for equal arguments.
PixelSample SamplePixels(SamplingUnit unit, Index num_tiles, double rate, std::uint64_t seed, int turn, Index view);

}  // namespace vesta::gs
