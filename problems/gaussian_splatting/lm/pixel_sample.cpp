#include "problems/gaussian_splatting/lm/pixel_sample.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernels/core/random.h"
#include "kernels/gaussian_splatting/types.h"

namespace vesta::gs {
namespace {

Index Share(double rate, Index total) {
  return std::clamp<Index>(std::llround(rate * static_cast<double>(total)), 1, total);
}

// Calls visit for `count` of the numbers below `total`, without replacement: the first entries of a random permutation
// (Fisher and Yates). order: memory to work in.
template <class Visit>
void Draw(Index count, Index total, CounterRandom& random, std::vector<Index>& order, const Visit& visit) {
  order.resize(static_cast<std::size_t>(total));
  std::iota(order.begin(), order.end(), Index{0});
  for (Index k = 0; k < count; ++k) {
    std::swap(order[static_cast<std::size_t>(k)], order[static_cast<std::size_t>(k + random.Below(total - k))]);
    visit(order[static_cast<std::size_t>(k)]);
  }
}

}  // namespace

PixelSample SamplePixels(SamplingUnit unit, Index num_tiles, double rate, std::uint64_t seed, int turn, Index view) {
  CounterRandom random(MixBits(seed), static_cast<std::uint64_t>(turn), static_cast<std::uint64_t>(view));
  PixelSample sample{std::vector<std::uint16_t>(static_cast<std::size_t>(num_tiles), 0)};
  std::vector<Index> order;
  const Index total = unit == SamplingUnit::kTiles ? num_tiles : splat::kTileSize, count = Share(rate, total);
  sample.scale = static_cast<double>(total) / static_cast<double>(count);
  if (unit == SamplingUnit::kTiles) {
    Draw(count, total, random, order, [&](Index tile) { sample.rows[static_cast<std::size_t>(tile)] = 0xffff; });
    return sample;
  }
  for (std::uint16_t& rows : sample.rows) {
    Draw(count, total, random, order, [&](Index row) { rows = static_cast<std::uint16_t>(rows | 1U << row); });
  }
  return sample;
}

}  // namespace vesta::gs
