// SPDX-License-Identifier: Apache-2.0
// Loops over the cached Jacobian of one view, for the instruction set chosen at run time (jacobian_cache.h).
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/gaussian_splatting/formulas/types.h"

namespace vesta::splat {

// In what an entry's numbers are kept.
enum class CacheFormat {
  kFull,  // the scalar of the model
  kHalf,  // 16 bits each
};

// Which pixels of a tile a splat is part of: bit x of rows[y].
struct TileMask {
  std::uint16_t rows[kTileSize];
};

// Where the entries are. A pair is a position in TileLists::ranks.
struct CacheLists {
  const TileMask* masks;                // [pairs]
  const std::int64_t* first_entry;      // [pairs]; a splat's pairs follow each other, and so do the splats
  const std::int64_t* splat_begin;      // [splats + 1] into the two below
  const std::uint32_t* pairs_of_splat;  // [pairs] by ascending tile
  const std::uint32_t* tiles_of_splat;  // [pairs]
};

// Numbers of one entry: its share of the pixel, and how far each colour differs from what lies behind.
inline constexpr int kEntryValues = 4;

// entries: kEntryValues numbers each, in an order that fill and the products share; must be readable for 64 bytes past
// the last.
template <class S>
struct CacheKernels {
  // masks[pair] of each pair of the tile.
  void (*masks)(const TileLists<S>& lists, int tile, TileMask* masks);
  // The entries of the tile's pairs. image: of the same lists.
  void (*fill)(const TileLists<S>& lists, const CacheLists& cache, int tile, const S* image, void* entries);
  // d_image for the splat tangents, by rank.
  void (*tangent)(const TileLists<S>& lists, const CacheLists& cache, const void* entries, int tile,
                  const SplatTangent<S>* tangents, S* d_image);
  // u_tiles[tile]: three planes of 16 x 16 pixels each, 0 beyond the image.
  void (*to_tiles)(const TileLists<S>& lists, int tile, const S* u, S* u_tiles);
  // sums[rank], for the splats [begin, end).
  void (*adjoint)(const TileLists<S>& lists, const CacheLists& cache, const void* entries, std::int64_t begin,
                  std::int64_t end, const S* u_tiles, SplatTangent<S>* sums);
};

// S = float: the kernels of one instruction set, which the CPU must have. S = double: the reference, of any.
template <class S>
const CacheKernels<S>& CacheKernelsFor(Isa isa, CacheFormat format);

}  // namespace vesta::splat
