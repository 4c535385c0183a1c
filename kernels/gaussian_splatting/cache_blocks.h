// The cached Jacobian of a view for a GPU, as block kernels (kernels/core/block_kernel.h): how entries are found,
// counted and filled, and products with them. What an entry is: cache_entry.h.
//
// Entries lie splat by splat in the order of depth, within a splat tile by tile, within a tile row by row, four numbers
// each side by side. In place of an index each pair of splat and tile has the mask of its pixels: an entry's position
// is that of the pair's first, and as many on as the mask has bits before its pixel's. The image's tangent is made tile
// by tile, one thread a pixel; the adjoint pair by pair in the order of the entries, one thread a row of a tile.
#pragma once

#include "kernels/gaussian_splatting/cache_entry.h"
#include "kernels/gaussian_splatting/raster_blocks.h"

namespace vesta::splat {

// A pair of splat and tile in the order of splats.
struct CachePair {
  TileMask mask;
  std::uint8_t above[kTileSize];  // entries in the rows above: at most 240
  std::uint32_t rank, tile;
};

// Of all pairs.
struct CachePairs {
  const CachePair* pairs;
  const std::int64_t* first_entry;  // [pairs + 1]
};

inline namespace VESTA_ISA {

// The four numbers of an entry, read and written at once: 8 bytes as 16 bits each.
template <class E>
struct alignas(kEntryValues * sizeof(E)) CacheEntry {
  E weight, contrast[3];
};

template <class S>
VESTA_HD inline void Keep(const S& x, S* kept) {
  *kept = x;
}
template <class S>
VESTA_HD inline void Keep(const S& x, Half* kept) {
  *kept = ToHalf(static_cast<float>(x));
}
template <class S>
VESTA_HD inline S Kept(const S& x) {
  return x;
}
template <class S>
VESTA_HD inline S Kept(const Half& x) {
  return static_cast<S>(FromHalf(x));
}

// Entries of a row to the left of pixel x.
VESTA_HD inline int EntriesLeftOf(std::uint32_t row, int x) { return PopCount(row & ((1U << x) - 1)); }

// For place e of a pair in the order of splats, whose mask is there: how many entries it has, and row by row.
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

// The masks of the pairs of a tile; that of pair k of the lists goes to pairs[places[k]].
template <class S>
struct MaskBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = 16;
  struct Shared {
    Splat<S> splats[kBatch];
    bool part[kBatch][kRasterThreads];  // is the splat part of the pixel
  };
  TileLists<S> lists;
  const std::uint32_t* places;
  CachePair* pairs;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const int thread = block.thread();
    const BlockPixel pixel(lists, block.id(), thread);
    Passing<S> passing(pixel);
    const std::int64_t end = lists.tile_begin[block.id() + 1];
    std::int64_t first = lists.tile_begin[block.id()];
    for (; first < end; first += kBatch) {
      if (block.Count(passing.open) == 0) break;
      const int count = BatchSize(first, end, kBatch);
      StageSplats(block, lists, first, count, shared.splats);
      for (int k = 0; k < count; ++k) {
        bool part = false;
        if (passing.open) {
          const Splat<S>& splat = shared.splats[k];
          const RowSpan<S> row = RowInTile(splat, pixel.y);
          const S alpha = AlphaAt(OffsetAt(static_cast<S>(pixel.x), splat.r, row.p0), row.peak);
          part = alpha > S(0) && passing.Take(alpha).alpha > S(0);
        }
        shared.part[k][pixel.in_tile()] = part;
      }
      block.Sync();
      const int k = thread / kTileSize, y = thread % kTileSize;
      if (k >= count) continue;
      std::uint32_t bits = 0;
      for (int x = 0; x < kTileSize; ++x) bits |= (shared.part[k][y * kTileSize + x] ? 1U : 0U) << x;
      Write(block.id(), first + k, y, bits);
    }
    // All pixels are closed.
    for (std::int64_t i = first * kTileSize + thread; i < end * kTileSize; i += kThreads) {
      Write(block.id(), i / kTileSize, static_cast<int>(i % kTileSize), 0);
    }
  }

 private:
  VESTA_HD void Write(std::int64_t tile, std::int64_t pair, int y, std::uint32_t bits) const {
    CachePair& to = pairs[places[pair]];
    to.mask.rows[y] = static_cast<std::uint16_t>(bits);
    if (y == 0) to.rank = lists.ranks[pair], to.tile = static_cast<std::uint32_t>(tile);
  }
};

// Where the entries of the pairs of a batch lie, in shared memory.
template <int kBatch>
struct StagedMasks {
  std::int64_t first[kBatch];
  std::uint16_t rows[kBatch][kTileSize];
  std::uint8_t above[kBatch][kTileSize];

  // Of the pairs [begin, begin + count) of the lists. A barrier must follow.
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
  VESTA_HD bool Has(int k, int x, int y) const { return (rows[k][y] >> x & 1U) != 0; }
  VESTA_HD std::int64_t Position(int k, int x, int y) const {
    return first[k] + above[k][y] + EntriesLeftOf(rows[k][y], x);
  }
};

// The entries of the pairs of a tile. image: of the same lists.
template <class S, class E>
struct FillBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = 128;
  struct Shared {
    Splat<S> splats[kBatch];
    StagedMasks<kBatch> masks;
  };
  TileLists<S> lists;
  const std::uint32_t* places;
  CachePairs cache;
  const S* image;
  CacheEntry<E>* entries;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    constexpr S kWeight = static_cast<S>(EntryScale<E>::kWeight), kContrast = static_cast<S>(EntryScale<E>::kContrast);
    const BlockPixel pixel(lists, block.id(), block.thread());
    const std::int64_t plane = std::int64_t{lists.width} * lists.height;
    Passing<S> passing(pixel);
    S behind[3];
    for (int c = 0; c < 3; ++c) behind[c] = pixel.inside ? image[c * plane + pixel.place] : S(0);
    const std::int64_t end = lists.tile_begin[block.id() + 1];
    for (std::int64_t first = lists.tile_begin[block.id()]; first < end; first += kBatch) {
      if (block.Count(passing.open) == 0) break;
      const int count = BatchSize(first, end, kBatch);
      shared.masks.Stage(block, cache, places, first, count);
      StageSplats(block, lists, first, count, shared.splats);
      for (int k = 0; k < count && passing.open; ++k) {
        const Splat<S>& splat = shared.splats[k];
        const RowSpan<S> row = RowInTile(splat, pixel.y);
        const S alpha = AlphaAt(OffsetAt(static_cast<S>(pixel.x), splat.r, row.p0), row.peak);
        if (!(alpha > S(0))) continue;
        const Blend<S> blend = passing.Take(alpha);
        if (!shared.masks.Has(k, pixel.x, pixel.y)) continue;  // it closed the pixel
        const S inverse = InverseBehind(blend);
        CacheEntry<E> entry;
        Keep(kWeight * blend.weight, &entry.weight);
        for (int c = 0; c < 3; ++c) {
          Keep(kContrast * EntryContrast(blend, inverse, splat.color[c], behind[c]), &entry.contrast[c]);
        }
        entries[shared.masks.Position(k, pixel.x, pixel.y)] = entry;
      }
    }
  }
};

// CacheKernels::tangent.
template <class S, class E>
struct CachedTangentBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = 128;
  struct Shared {
    Splat<S> splats[kBatch];
    SplatTangent<S> tangents[kBatch];  // in units of the entries
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
    const int thread = block.thread();
    const BlockPixel pixel(lists, block.id(), thread);
    S d_color[3] = {S(0), S(0), S(0)};
    const std::int64_t end = lists.tile_begin[block.id() + 1];
    for (std::int64_t first = lists.tile_begin[block.id()]; first < end; first += kBatch) {
      const int count = BatchSize(first, end, kBatch);
      block.Sync();  // the batch before is done with
      if (thread < count) {
        const SplatTangent<S>& tangent = tangents[lists.ranks[first + thread]];
        for (int i = 0; i < kSplatTangent; ++i) shared.tangents[thread].w[i] = Unit(i) * tangent.w[i];
      }
      shared.masks.Stage(block, cache, places, first, count);
      StageSplats(block, lists, first, count, shared.splats);
      for (int k = 0; k < count; ++k) {
        if (!shared.masks.Has(k, pixel.x, pixel.y)) continue;
        const CacheEntry<E> entry = entries[shared.masks.Position(k, pixel.x, pixel.y)];
        const Splat<S>& splat = shared.splats[k];
        const RowSpan<S> row = RowInTile(splat, pixel.y);
        const S* w = shared.tangents[k].w;
        const S p = OffsetAt(static_cast<S>(pixel.x), splat.r, row.p0);
        const S psi =
            Psi(PsiLinear(w[kXi], w[kKappa], row.q), PsiConstant(w[kZeta], w[kSigma], w[kLambda], row.q), w[kRho], p);
        const S weight = Kept<S>(entry.weight);
        for (int c = 0; c < 3; ++c) {
          d_color[c] = AddEntry(weight, Kept<S>(entry.contrast[c]), psi, w[kColor + c], d_color[c]);
        }
      }
    }
    if (!pixel.inside) return;
    const std::int64_t plane = std::int64_t{lists.width} * lists.height;
    for (int c = 0; c < 3; ++c) d_image[c * plane + pixel.place] = d_color[c];
  }

 private:
  VESTA_HD static constexpr S Unit(int component) {
    return static_cast<S>(component < kColor ? 1 / (EntryScale<E>::kWeight * EntryScale<E>::kContrast)
                                             : 1 / EntryScale<E>::kWeight);
  }
};

// sums[e] = the adjoint's sums of the pair at place e of [0, size) in the order of splats.
template <class S, class E>
struct CachedAdjointBlock {
  static constexpr int kThreads = kRasterThreads, kBatch = 16;
  struct Shared {
    Splat<S> splats[kBatch];
    S rows[kBatch][kTileSize][kAdjointRowSums];
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
      shared.splats[thread] = InTile(lists, pair.tile, lists.splats[pair.rank]);
    }
    block.Sync();
    const int pair = thread / kTileSize, y = thread % kTileSize;
    if (pair < count) AddRow(shared.splats[pair], first + pair, y, shared.rows[pair][y]);
    block.Sync();
    if (thread >= count * kSplatTangent) return;
    const int k = thread / kSplatTangent, i = thread % kSplatTangent;
    constexpr S kWeight = static_cast<S>(1 / EntryScale<E>::kWeight);
    constexpr S kContrast = static_cast<S>(1 / (EntryScale<E>::kWeight * EntryScale<E>::kContrast));
    sums[first + k].w[i] = (i < kColor ? kContrast : kWeight) * AddAdjointRows(shared.splats[k], shared.rows[k], i);
  }

 private:
  VESTA_HD void AddRow(const Splat<S>& splat, std::int64_t place, int y, S sum[kAdjointRowSums]) const {
    const CachePair& pair = cache.pairs[place];
    const CacheEntry<E>* at = entries + cache.first_entry[place] + pair.above[y];
    const RowSpan<S> row = RowInTile(splat, y);
    const std::int64_t plane = std::int64_t{lists.width} * lists.height;
    const std::int64_t line = (std::int64_t{pair.tile} / lists.tiles_x * kTileSize + y) * lists.width +
                              std::int64_t{pair.tile} % lists.tiles_x * kTileSize;
    AdjointRow<S> total;
    for (std::uint32_t bits = pair.mask.rows[y]; bits != 0; bits &= bits - 1) {
      const int x = PopCount(~bits & (bits - 1));  // of the lowest bit
      const CacheEntry<E> entry = *at++;
      const S weight = Kept<S>(entry.weight);
      S pixel_u[3], gathered(0);
      for (int c = 0; c < 3; ++c) {
        pixel_u[c] = u[c * plane + line + x];
        gathered = Fma(Kept<S>(entry.contrast[c]), pixel_u[c], gathered);
      }
      total.Add(weight * gathered, weight, pixel_u, OffsetAt(static_cast<S>(x), splat.r, row.p0));
    }
    for (int i = 0; i < kAdjointRowSums; ++i) sum[i] = total.sum[i];
  }
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
