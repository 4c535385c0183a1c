// SPDX-License-Identifier: Apache-2.0
// The lists of splats by tile as a GPU makes them: each step one function of an index, run for all indices in any
// order, with stable sorts by key and sums of counts in between. The lists are those of TileBins.
//
//   Gaussians --sort by depth--> GatherSorted --> CountTiles --running sum--> EmitPairs --sort by tile--> PlacePairs
#pragma once

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/tiles/tile_coverage.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// For rank r < count. keys, indices: of ProjectKernels::project, sorted by key, so that those not seen come last.
template <class S>
struct GatherSorted {
  const std::uint32_t *keys, *indices;
  Index count;
  const Splat<S>* unsorted;
  Splat<S>* splats;  // by rank; room for as many as are seen
  std::int32_t* rank_of;

  VESTA_HD void operator()(Index r) const {
    const bool seen = keys[r] != kNotSeen;
    rank_of[indices[r]] = seen ? static_cast<std::int32_t>(r) : -1;
    if (seen) splats[r] = unsorted[indices[r]];
  }
};

// For rank r < count: *seen = how many Gaussians are seen. seen is 0 before.
struct CountSeen {
  const std::uint32_t* keys;
  Index count;
  Index* seen;

  VESTA_HD void operator()(Index r) const {
    if (keys[r] != kNotSeen && (r + 1 == count || keys[r + 1] == kNotSeen)) *seen = r + 1;
  }
};

struct TileGrid {
  int width, height, tiles_x, tiles_y;  // of the image, in pixels and in tiles

  TileGrid(int w, int h)
      : width(w), height(h), tiles_x((w + kTileSize - 1) / kTileSize), tiles_y((h + kTileSize - 1) / kTileSize) {}
  int num_tiles() const { return tiles_x * tiles_y; }
  // Bits of the largest tile's number.
  int key_bits() const {
    int bits = 1;
    while (bits < 31 && (num_tiles() - 1) >> bits > 0) ++bits;
    return bits;
  }
};

// The pairs of splat and tile by entry, in the order of splats and of each one's tiles.
struct PairArrays {
  std::uint32_t *tiles, *ranks, *entries;  // entries[e] = e: what is sorted along

  VESTA_HD void Write(Index e, int tile, Index rank) const {
    tiles[e] = static_cast<std::uint32_t>(tile);
    ranks[e] = static_cast<std::uint32_t>(rank);
    entries[e] = static_cast<std::uint32_t>(e);
  }
};

// For rank r: in how many tiles its splat is listed.
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

// Splats of more tiles than this are left to whole blocks of threads (wide_splats.h).
inline constexpr Index kFewTiles = 64;
VESTA_HD inline bool IsWide(const Index* splat_begin, Index r) {
  return splat_begin[r + 1] - splat_begin[r] > kFewTiles;
}

// For rank r: an entry for each of its tiles, from splat_begin[r] on; not for wide splats.
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

// For pair i, the entries being sorted by tile: its rank, and tile_begin where a tile's pairs begin. tile_begin is all
// 0 before, which is right where there are no pairs.
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

// For i = kN * r + component: the sum of that component over the entries of splat r, in the order of its tiles; not for
// wide splats. Records are kN scalars.
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
