// SPDX-License-Identifier: Apache-2.0
// Tile lists of a view, on the host with the GPU's steps (tile_pairs.h).
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "kernels/gaussian_splatting/tiles/wide_splats.h"
#include "tests/support/emulated_block.h"
#include "tests/support/splat_scenes.h"

namespace vesta::test {

template <class T>
std::vector<T> Permuted(const std::vector<T>& values, const std::vector<std::size_t>& order) {
  std::vector<T> result;
  result.reserve(order.size());
  for (const std::size_t i : order) result.push_back(values[i]);
  return result;
}

// Keeps the order of equal keys, like a radix sort.
inline void SortPairs(std::vector<std::uint32_t>& keys, std::vector<std::uint32_t>& values) {
  std::vector<std::size_t> order(keys.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });
  keys = Permuted(keys, order);
  values = Permuted(values, order);
}

template <class S>
struct DeviceLists {
  splat::TileGrid grid;
  std::vector<splat::Splat<S>> splats;
  std::vector<std::int32_t> rank_of;
  std::vector<Index> splat_begin;
  std::vector<std::int64_t> tile_begin;
  std::vector<std::uint32_t> ranks, entries, wide;
  S background[3];

  DeviceLists(const splat::Model<S>& model, const splat::PosedCamera& view, const double* background_color)
      : grid(view.width, view.height) {
    for (int c = 0; c < 3; ++c) background[c] = static_cast<S>(background_color[c]);
    const Index count = model.count;
    std::vector<std::uint32_t> keys(static_cast<std::size_t>(count)), indices(keys.size());
    std::vector<splat::Splat<S>> unsorted(keys.size());
    splat::GetProjectKernels<S>(model.active_sh_degree).project(model, view, 0, count, keys.data(), unsorted.data());
    std::iota(indices.begin(), indices.end(), 0U);
    SortPairs(keys, indices);
    Index seen = 0;
    ForEachBackwards(count, splat::CountVisible{keys.data(), count, &seen});
    splats.resize(static_cast<std::size_t>(seen));
    rank_of.resize(keys.size());
    ForEachBackwards(count, splat::GatherSorted<S>{keys.data(), indices.data(), count, unsorted.data(), splats.data(),
                                                   rank_of.data()});
    splat_begin.resize(splats.size() + 1);
    std::vector<Index> counts(splats.size() + 1, 0);
    ForEachBackwards(seen, splat::CountTiles<S>{grid, splats.data(), counts.data()});
    std::exclusive_scan(counts.begin(), counts.end(), splat_begin.begin(), Index{0});
    const auto pairs = static_cast<std::size_t>(splat_begin.back());
    std::vector<std::uint32_t> tiles(pairs), rank_of_entry(pairs);
    entries.resize(pairs);
    const splat::PairArrays arrays{tiles.data(), rank_of_entry.data(), entries.data()};
    ForEachBackwards(seen, splat::EmitPairs<S>{grid, splats.data(), splat_begin.data(), arrays});
    wide.resize(static_cast<std::size_t>(splat::NumWideSlots(static_cast<Index>(pairs))), 0);
    ForEachBackwards(seen, splat::MarkWideSplats{splat_begin.data(), wide.data()});
    Emulate(splat::EmitWidePairs<S>{Wide(), grid, splats.data(), splat_begin.data(), arrays}, NumWideBlocks(),
            ThreadOrder::kShuffled);
    SortPairs(tiles, entries);
    ranks.resize(pairs);
    tile_begin.resize(static_cast<std::size_t>(grid.num_tiles()) + 1, 0);
    ForEachBackwards(static_cast<Index>(pairs),
                     splat::PlacePairs{tiles.data(), entries.data(), rank_of_entry.data(), static_cast<Index>(pairs),
                                       grid.num_tiles(), ranks.data(), tile_begin.data()});
  }
  splat::WideSlots Wide() const { return {wide.data(), static_cast<Index>(wide.size())}; }
  Index NumWideBlocks() const { return splat::WideSlots::NumBlocks(static_cast<Index>(wide.size())); }
  splat::TileLists<S> Lists() const {
    return {splats.data(), tile_begin.data(), ranks.data(), grid.width,
            grid.height,   grid.tiles_x,      grid.tiles_y, {background[0], background[1], background[2]}};
  }
};

}  // namespace vesta::test
