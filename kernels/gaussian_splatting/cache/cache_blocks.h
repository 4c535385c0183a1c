// SPDX-License-Identifier: Apache-2.0
// The cached Jacobian of a view on a GPU. Block kernels (kernels/core/block_kernel.h) find, count and compute the
// entries, and multiply with them. An entry belongs to one pixel and one contributing splat (cache_entry.h).
//
// Entries are ordered by splat (in depth order), then by tile, row and column. The four numbers of an entry are
// adjacent. Each (splat, tile) pair stores a mask of its pixels. The index of an entry is the first index of its pair
// plus the number of mask bits before its pixel.
//
// The tangent product uses one block of threads per tile and one thread per pixel. The adjoint product processes the
// pairs in the order of the entries, with one thread per row of a tile.
#pragma once

#include "kernels/gaussian_splatting/cache/cache_entry.h"
#include "kernels/gaussian_splatting/raster/splat_sums.h"
#include "kernels/gaussian_splatting/tiles/tile_block.h"

namespace vesta::splat {

// A (splat, tile) pair. Pairs are ordered by splat, then by tile. rank: index of the splat in depth order.
struct CachePair {
  TileMask mask;
  std::uint8_t above[kTileSize];  // number of entries in the rows above, at most 240
  std::uint32_t rank, tile;
};

// All pairs. first_entry[e]: index of the first entry of pair e; the last element is the number of entries.
struct CachePairs {
  const CachePair* pairs;
  const std::int64_t* first_entry;  // [pairs + 1]
};

inline namespace VESTA_ISA {

// Convert a number of an entry to and from the cache's format: S itself, or Half.
template <class S>
VESTA_HD inline void StoreValue(const S& x, S* stored) {
  *stored = x;
}
template <class S>
VESTA_HD inline void StoreValue(const S& x, Half* stored) {
  *stored = ToHalf(static_cast<float>(x));
}
template <class S>
VESTA_HD inline S LoadValue(const S& x) {
  return x;
}
template <class S>
VESTA_HD inline S LoadValue(const Half& x) {
  return static_cast<S>(FromHalf(x));
}

// The four numbers of an entry, accessed at once (8 bytes in 16-bit format).
template <class E>
struct alignas(kEntryValues * sizeof(E)) CacheEntry {
  E weight, contrast[3];

  template <class S>
  VESTA_HD Entry<S> Read() const {
    const CacheEntry stored = *this;
    return {LoadValue<S>(stored.weight),
            {LoadValue<S>(stored.contrast[0]), LoadValue<S>(stored.contrast[1]), LoadValue<S>(stored.contrast[2])}};
  }
};

// Number of entries of a row to the left of pixel x.
VESTA_HD inline int EntriesLeftOf(std::uint32_t row, int x) { return PopCount(row & ((1U << x) - 1)); }

// For pair e, whose mask must be set: counts[e] = number of entries of the pair. Also sets its `above`.
struct CountEntries {
  CachePair* pairs;
  std::int64_t* counts;

  VESTA_HD void operator()(std::int64_t e) const {
    CachePair& pair = pairs[e];
    int count = 0;
    for (int y = 0; y < kTileSize; ++y) {
      pair.above[y] = static_cast<std::uint8_t>(count);
      count += PopCount(pair.mask.rows[y]);
    }
    counts[e] = count;
  }
};

// Computes the masks of a tile's pairs. Pair k of the tile lists is pair places[k] of the cache.
template <class S>
struct MaskBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = 16;
  struct Shared {
    SplatBatch<S, kBatch> splats;
    bool part[kBatch][kRasterThreads];  // whether each splat contributes to each pixel
  };
  TileLists<S> lists;
  const std::uint32_t* places;
  CachePair* pairs;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const int k = block.thread() / kTileSize, y = block.thread() % kTileSize;
    const BlockPixel pixel(lists, TileOf(block), block.thread());
    const std::int64_t remaining = SumOverPixels<bool>(
        block, lists, pixel, shared.splats, [&](int, const Blend<S>& blend) { return blend.alpha > S(0); },
        [&](int splat, bool part) { shared.part[splat][pixel.in_tile()] = part; },
        [&](std::int64_t first, int count) {
          if (k >= count) return;
          std::uint32_t bits = 0;
          for (int x = 0; x < kTileSize; ++x) bits |= (shared.part[k][y * kTileSize + x] ? 1U : 0U) << x;
          Write(block.id(), first + k, y, bits);
        });
    ForEachRemaining<kTileSize>(block, lists, remaining,
                                [&](std::int64_t pair, int row) { Write(block.id(), pair, row, 0); });
  }

 private:
  VESTA_HD void Write(std::int64_t tile, std::int64_t pair, int y, std::uint32_t bits) const {
    CachePair& to = pairs[places[pair]];
    to.mask.rows[y] = static_cast<std::uint16_t>(bits);
    if (y == 0) to.rank = lists.ranks[pair], to.tile = static_cast<std::uint32_t>(tile);
  }
};

// Masks and first entries of a batch of pairs, in shared memory.
template <int kBatch>
struct StagedMasks {
  std::int64_t first[kBatch];
  std::uint16_t rows[kBatch][kTileSize];
  std::uint8_t above[kBatch][kTileSize];

  // Loads the pairs begin .. begin + count - 1 of the tile lists. Call Sync afterwards.
  template <class Block>
  VESTA_HD void Stage(Block& block, const CachePairs& cache, const std::uint32_t* places, std::int64_t begin,
                      int count) {
    for (int i = block.thread(); i < count * kTileSize; i += kRasterThreads) {
      const int k = i / kTileSize, y = i % kTileSize;
      const std::int64_t place = places[begin + k];
      rows[k][y] = cache.pairs[place].mask.rows[y];
      above[k][y] = cache.pairs[place].above[y];
      if (y == 0) first[k] = cache.first_entry[place];
    }
  }
  // For pair k of the batch and pixel (x, y) of the tile: whether there is an entry, and its index.
  VESTA_HD bool Has(int k, int x, int y) const { return (rows[k][y] >> x & 1U) != 0; }
  VESTA_HD std::int64_t Position(int k, int x, int y) const {
    return first[k] + above[k][y] + EntriesLeftOf(rows[k][y], x);
  }
};

// Computes the entries of a tile's pairs. image: rendered from the same tile lists. places: see MaskBlock.
template <class S, class E>
struct FillBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = 128;
  struct Shared {
    MaskedSplatBatch<S, kBatch> splats;
    StagedMasks<kBatch> masks;
  };
  TileLists<S> lists;
  const std::uint32_t* places;
  CachePairs cache;
  const S* image;
  CacheEntry<E>* entries;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const BlockPixel pixel(lists, TileOf(block), block.thread());
    PixelBlending<S> blending(pixel);
    S behind[3] = {pixel.Load(image, 0), pixel.Load(image, 1), pixel.Load(image, 2)};
    ForEachHit(
        block, lists, pixel, blending, shared.splats,
        [&](std::int64_t first, int count) { shared.masks.Stage(block, cache, places, first, count); },
        [&](int k, const S&, const S&, const Blend<S>& blend) {
          if (!shared.masks.Has(k, pixel.x, pixel.y)) return;  // no entry: this splat closed the pixel
          const EntryMaker<E, S> entry(blend);
          CacheEntry<E> stored;
          StoreValue(entry.Weight(), &stored.weight);
          for (int c = 0; c < 3; ++c) {
            StoreValue(entry.Contrast(shared.splats[k].color[c], behind[c]), &stored.contrast[c]);
          }
          entries[shared.masks.Position(k, pixel.x, pixel.y)] = stored;
        });
  }
};

// GPU version of CacheKernels::tangent. places: see MaskBlock.
template <class S, class E>
struct CachedTangentBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = 128;
  struct Shared {
    Splat<S> splats[kBatch];
    SplatTangent<S> tangents[kBatch];  // scaled to the units of the entries
    StagedMasks<kBatch> masks;
  };
  TileLists<S> lists;
  const std::uint32_t* places;
  CachePairs cache;
  const CacheEntry<E>* entries;
  const SplatTangent<S>* tangents;
  S* d_image;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const BlockPixel pixel(lists, TileOf(block), block.thread());
    S d_color[3] = {S(0), S(0), S(0)};
    const auto go_on = [&] {
      block.Sync();
      return true;
    };
    ForEachBatch<kBatch>(block, lists, go_on, [&](std::int64_t first, int count) {
      const int thread = block.thread();
      if (thread < count) {
        const std::uint32_t rank = lists.ranks[first + thread];
        shared.splats[thread] = InTile(lists.splats[rank], TileOrigin<S>(lists, TileOf(block)));
        shared.tangents[thread] = tangents[rank];
        DivideByEntryScale<E>(shared.tangents[thread]);
      }
      shared.masks.Stage(block, cache, places, first, count);
      block.Sync();
      for (int k = 0; k < count; ++k) {
        if (!shared.masks.Has(k, pixel.x, pixel.y)) continue;
        const Entry<S> entry = entries[shared.masks.Position(k, pixel.x, pixel.y)].template Read<S>();
        const Splat<S>& splat = shared.splats[k];
        const RowSpan<S> row = RowInTile(splat, pixel.y);
        const S p = OffsetAt(static_cast<S>(pixel.x), splat.r, row.p0);
        const SplatTangent<S>& tangent = shared.tangents[k];
        const S psi = Psi(tangent, p, row.q);
        for (int c = 0; c < 3; ++c) {
          d_color[c] = AddEntry(entry.weight, entry.contrast[c], psi, tangent.w[kColor + c], d_color[c]);
        }
      }
    });
    for (int c = 0; c < 3; ++c) pixel.Store(d_image, c, d_color[c]);
  }
};

// sums[e] = the part of pair e in J^T u: the cotangent of the pair's splat (without the sums for density control),
// summed over the pixels of its tile. size: number of pairs.
template <class S, class E>
struct CachedAdjointBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = 16;
  struct Shared {
    Splat<S> splats[kBatch];
    S rows[kBatch][kTileSize][kCotangentRowSums];
  };
  TileLists<S> lists;
  CachePairs cache;
  const CacheEntry<E>* entries;
  std::int64_t size;
  const S* u;
  SplatTangent<S>* sums;

  static constexpr std::int64_t NumBlocks(std::int64_t size) { return (size + kBatch - 1) / kBatch; }

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const int thread = block.thread();
    const std::int64_t first = block.id() * kBatch;
    const int count = BatchSize(first, size, kBatch);
    if (thread < count) {
      const CachePair& pair = cache.pairs[first + thread];
      shared.splats[thread] = InTile(lists.splats[pair.rank], TileOrigin<S>(lists, static_cast<int>(pair.tile)));
    }
    block.Sync();
    const int pair = thread / kTileSize, y = thread % kTileSize;
    if (pair < count) AddRow(shared.splats[pair], first + pair, pair, y, shared.rows[pair][y]);
    block.Sync();
    if (thread >= count * kSplatSums) return;
    const int k = thread / kSplatSums, i = thread % kSplatSums;
    sums[first + k].w[i] = InverseEntryScale<E, S>(i) * CotangentFromRows(shared.splats[k], shared.rows[k], k, i);
  }

 private:
  VESTA_HD void AddRow(const Splat<S>& splat, std::int64_t place, int k, int y, S sum[kCotangentRowSums]) const {
    const CachePair& pair = cache.pairs[place];
    const CacheEntry<E>* at = entries + cache.first_entry[place] + pair.above[y];
    const RowSpan<S> row = RowInTile(splat, y);
    const std::int64_t plane = std::int64_t{lists.width} * lists.height;
    const int tile = static_cast<int>(pair.tile);
    const std::int64_t line =
        std::int64_t{tile / lists.tiles_x * kTileSize + y} * lists.width + tile % lists.tiles_x * kTileSize;
    CotangentRow<S> total;
    for (std::uint32_t bits = pair.mask.rows[y]; bits != 0; bits &= bits - 1) {
      const int x = LowestBit(bits);
      const Entry<S> entry = (at++)->template Read<S>();
      const S g = AddColors(
          entry, [&](int c) { return u[c * plane + line + x]; }, total);
      total.AddShape(g, OffsetAt(static_cast<S>(x), splat.r, row.p0));
    }
    for (int i = 0; i < kCotangentRowSums; ++i) sum[PlaceOfRowSum(k, y, i)] = total.sum[i];
  }
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
