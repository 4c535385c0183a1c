// SPDX-License-Identifier: Apache-2.0
// Builds, on a GPU, the list of splats of each tile (TileLists in types.h). Each step is a functor that is called for
// all indices in any order. Stable sorts by key and running sums run between the steps. TileBins builds the same lists
// on the CPU. The rank of a splat is its index in depth order.
//
//   Gaussians --sort by depth--> GatherSorted --> CountTiles --running sum--> EmitPairs --sort by tile--> PlacePairs
#pragma once

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/tiles/tile_coverage.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// For rank r < count: copies the splat to its rank, and sets rank_of. keys: the depth keys from
// ProjectKernels::project, in ascending order. indices: the permutation that sorts them, so Gaussian indices[r] has the
// key keys[r]. Invisible Gaussians have the largest key, kInvisible, and come last.
template <class S>
struct GatherSorted {
  const std::uint32_t *keys, *indices;
  Index count;
  const Splat<S>* unsorted;
  Splat<S>* splats;  // by rank; capacity for all visible splats
  std::int32_t* rank_of;

  VESTA_HD void operator()(Index r) const {
    const bool seen = keys[r] != kInvisible;
    rank_of[indices[r]] = seen ? static_cast<std::int32_t>(r) : -1;
    if (seen) splats[r] = unsorted[indices[r]];
  }
};

// For rank r < count: sets *seen, which must be 0 before, to the number of visible Gaussians. keys: sorted.
struct CountVisible {
  const std::uint32_t* keys;
  Index count;
  Index* seen;

  VESTA_HD void operator()(Index r) const {
    if (keys[r] != kInvisible && (r + 1 == count || keys[r + 1] == kInvisible)) *seen = r + 1;
  }
};

struct TileGrid {
  int width, height, tiles_x, tiles_y;  // image size in pixels and in tiles

  TileGrid(int w, int h)
      : width(w), height(h), tiles_x((w + kTileSize - 1) / kTileSize), tiles_y((h + kTileSize - 1) / kTileSize) {}
  int num_tiles() const { return tiles_x * tiles_y; }
  // Number of bits of the largest tile index.
  int key_bits() const {
    int bits = 1;
    while (bits < 31 && (num_tiles() - 1) >> bits > 0) ++bits;
    return bits;
  }
};

// The (splat, tile) pairs, ordered by splat, then by tile. The entry of a pair is its index in this order.
struct PairArrays {
  std::uint32_t *tiles, *ranks, *entries;  // entries[e] = e; the sort by tile permutes it

  VESTA_HD void Write(Index e, int tile, Index rank) const {
    tiles[e] = static_cast<std::uint32_t>(tile);
    ranks[e] = static_cast<std::uint32_t>(rank);
    entries[e] = static_cast<std::uint32_t>(e);
  }
};

// For rank r: counts[r] = number of tiles that the splat touches.
template <class S>
struct CountTiles {
  TileGrid grid;
  const Splat<S>* splats;
  Index* counts;

  VESTA_HD void operator()(Index r) const {
    const TileRows<S> rows(splats[r], grid.tiles_x, grid.tiles_y, grid.width, grid.height);
    Index count = 0;
    for (int row = rows.begin; row < rows.end; ++row) count += rows.CountIn(row);
    counts[r] = count;
  }
};

// Splats that touch more tiles than this are wide: a block of threads processes each of them (wide_splats.h).
// splat_begin[r]: first entry of the splat of rank r.
inline constexpr Index kFewTiles = 64;
VESTA_HD inline bool IsWide(const Index* splat_begin, Index r) {
  return splat_begin[r + 1] - splat_begin[r] > kFewTiles;
}

// For rank r: writes, from entry splat_begin[r] on, a pair for each tile that the splat touches. Skips wide splats.
template <class S>
struct EmitPairs {
  TileGrid grid;
  const Splat<S>* splats;
  const Index* splat_begin;
  PairArrays pairs;

  VESTA_HD void operator()(Index r) const {
    if (IsWide(splat_begin, r)) return;
    Index e = splat_begin[r];
    VisitTiles(splats[r], grid.tiles_x, grid.tiles_y, grid.width, grid.height,
               [&](int tile) { pairs.Write(e++, tile, r); });
  }
};

// For pair i in the order by tile: stores the rank of its splat. If i is the first pair of a tile, stores i in
// tile_begin. tiles, entries: sorted by tile. tile_begin must be 0 before.
struct PlacePairs {
  const std::uint32_t *tiles, *entries, *rank_of_entry;
  Index pairs;
  int num_tiles;
  std::uint32_t* ranks;
  std::int64_t* tile_begin;  // [num_tiles + 1]

  VESTA_HD void operator()(Index i) const {
    ranks[i] = rank_of_entry[entries[i]];
    const Index tile = tiles[i];
    for (Index t = i == 0 ? 0 : Index{tiles[i - 1]} + 1; t <= tile; ++t) tile_begin[t] = i;
    if (i + 1 < pairs) return;
    for (Index t = tile + 1; t <= num_tiles; ++t) tile_begin[t] = pairs;
  }
};

// Each entry has a record of kN scalars. For i = kN * r + component: sums[i] = the sum of this component over the
// entries of the splat of rank r, in the order of its tiles. Skips wide splats.
template <class S, int kN>
struct SumEntries {
  const Index* splat_begin;
  const S* records;
  S* sums;

  VESTA_HD void operator()(Index i) const {
    const Index r = i / kN, component = i - kN * r;
    if (IsWide(splat_begin, r)) return;
    S sum(0);
    for (Index e = splat_begin[r]; e < splat_begin[r + 1]; ++e) sum += records[kN * e + component];
    sums[i] = sum;
  }
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
