// A random part of the tiles of an image.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

struct TileSample {
  std::vector<bool> kept;  // [tiles]
  // Tiles there are over tiles kept: what sums over those kept are to be multiplied by. Every tile is as likely as any.
  double scale = 1;
};

// round(rate * num_tiles) of them, at least one, without replacement; the same for equal arguments. rate within (0, 1].
TileSample SampleTiles(Index num_tiles, double rate, std::uint64_t seed, int turn, Index view);

}  // namespace vesta::gs
