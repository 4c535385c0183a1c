// SPDX-License-Identifier: Apache-2.0
// Loops over the cached Jacobian of one view (jacobian_cache.h), for the instruction set chosen at run time. The rank
// of a splat is its index in depth order.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/gaussian_splatting/formulas/types.h"

namespace vesta::splat {

// Number format of an entry.
enum class CacheFormat {
  kFull,  // the scalar of the model
  kHalf,  // 16 bits each
};

// The pixels of a tile to which a splat contributes: bit x of rows[y].
struct TileMask {
  std::uint16_t rows[kTileSize];
};

// Where the entries are stored. A pair is an index into TileLists::ranks.
struct CacheLists {
  const TileMask* masks;                // [pairs]
  const std::int64_t* first_entry;      // [pairs]; entries are ordered by splat, then by tile
  const std::int64_t* splat_begin;      // [splats + 1] first index of each splat in the two arrays below
  const std::uint32_t* pairs_of_splat;  // [pairs] the pairs of each splat, by ascending tile
  const std::uint32_t* tiles_of_splat;  // [pairs]
};

// Numbers per entry (cache_entry.h).
inline constexpr int kEntryValues = 4;

// entries: kEntryValues numbers per entry. Only fill, tangent and adjoint access the entries, because their layout
// depends on the vector width. The memory must be readable up to 64 bytes past the last entry.
template <class S>
struct CacheKernels {
  // Computes masks[pair] for each pair of the tile.
  void (*masks)(const TileLists<S>& lists, int tile, TileMask* masks);
  // Computes the entries of the tile's pairs. image: rendered from the same lists.
  void (*fill)(const TileLists<S>& lists, const CacheLists& cache, int tile, const S* image, void* entries);
  // Computes the pixels of the tile in d_image = J tangents. tangents: by rank.
  void (*tangent)(const TileLists<S>& lists, const CacheLists& cache, const void* entries, int tile,
                  const SplatTangent<S>* tangents, S* d_image);
  // Copies u to u_tiles[tile]: three planes of 16 x 16 pixels, 0 outside the image.
  void (*to_tiles)(const TileLists<S>& lists, int tile, const S* u, S* u_tiles);
  // Computes sums[rank], the cotangent J^T u of each splat, for ranks begin .. end - 1. u_tiles: from to_tiles.
  void (*adjoint)(const TileLists<S>& lists, const CacheLists& cache, const void* entries, std::int64_t begin,
                  std::int64_t end, const S* u_tiles, SplatTangent<S>* sums);
};

// S = float: the kernels of `isa`, which the CPU must support. S = double: the reference, for any `isa`.
template <class S>
const CacheKernels<S>& CacheKernelsFor(Isa isa, CacheFormat format);

}  // namespace vesta::splat
