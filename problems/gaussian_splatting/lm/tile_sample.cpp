#include "problems/gaussian_splatting/lm/tile_sample.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernels/core/random.h"

namespace vesta::gs {

TileSample SampleTiles(Index num_tiles, double rate, std::uint64_t seed, int turn, Index view) {
  const Index count = std::clamp<Index>(std::llround(rate * static_cast<double>(num_tiles)), 1, num_tiles);
  CounterRandom random(MixBits(seed), static_cast<std::uint64_t>(turn), static_cast<std::uint64_t>(view));
  std::vector<Index> order(static_cast<std::size_t>(num_tiles));
  std::iota(order.begin(), order.end(), Index{0});
  TileSample sample{std::vector<bool>(order.size()), static_cast<double>(num_tiles) / static_cast<double>(count)};
  // The first entries of a random permutation (Fisher and Yates).
  for (Index k = 0; k < count; ++k) {
    std::swap(order[static_cast<std::size_t>(k)], order[static_cast<std::size_t>(k + random.Below(num_tiles - k))]);
    sample.kept[static_cast<std::size_t>(order[static_cast<std::size_t>(k)])] = true;
  }
  return sample;
}

}  // namespace vesta::gs
