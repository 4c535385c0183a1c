// SPDX-License-Identifier: Apache-2.0
// The cached Jacobian of a view on the CPU: computes the entries (cache_entry.h) and multiplies with them. A row of a
// tile is one or more SIMD vectors.
#pragma once

#include <algorithm>

#include "kernels/gaussian_splatting/cache/cache_entry.h"
#include "kernels/gaussian_splatting/raster/splat_sums.h"
#include "kernels/gaussian_splatting/raster/traverse_splats.h"
#include "kernels/math/packed_lanes.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// The mask bits of vector k of a row. row: TileMask::rows.
template <class V>
inline std::uint32_t VectorBits(std::uint32_t row, int k) {
  constexpr int kWidth = Lanes<V>::kWidth;
  return row >> (k * kWidth) & ((1U << kWidth) - 1);
}

// Calls visit(row, k, bits) for each vector k of each row with at least one entry, in the order of the entries.
template <class V, class Visit>
[[gnu::always_inline]] inline void ForEachVector(const TileMask& mask, const Visit& visit) {
  std::uint32_t todo = 0;
  for (int row = 0; row < kTileSize; ++row) todo |= (mask.rows[row] != 0 ? 1U : 0U) << row;
  for (; todo != 0; todo &= todo - 1) {
    const int row = std::countr_zero(todo);
    for (int k = 0; k < kTileSize / Lanes<V>::kWidth; ++k) {
      const std::uint32_t bits = VectorBits<V>(mask.rows[row], k);
      if (Lanes<V>::kWidth == kTileSize || bits != 0) visit(row, k, bits);
    }
  }
}

// Prefetch distance in (splat, tile) pairs, and number of 64-byte cache lines prefetched per pair.
inline constexpr int kAhead = 3, kLinesAhead = 6;
inline void Prefetch(const void* p) { __builtin_prefetch(p); }

template <class V, class S>
struct MaskPass {
  using L = Lanes<V>;
  TileMask* masks;

  struct State {
    TileMask mask;
  };
  State Begin(const Splat<S>&) const { return {}; }
  void Pixels(State& state, S, int offset, const V&, const Blend<V>& blend) {
    state.mask.rows[offset / kTileSize] |=
        static_cast<std::uint16_t>(L::Bits(blend.alpha > V(0)) << (offset % kTileSize));
  }
  void End(State& state, std::int64_t pair) { masks[pair] = state.mask; }
  void Skip(std::int64_t pair) { masks[pair] = {}; }
};

template <class V, class S, class E>
struct EntryPass {
  using L = Lanes<V>;
  CacheLists cache;
  E* entries;
  alignas(64) S behind[3][kTilePixels];             // sum of the weighted colours behind the current splat (passes.h)
  alignas(64) S values[kEntryValues][kTilePixels];  // of the current splat

  struct State {
    V c[3];
  };
  State Begin(const Splat<S>& splat) const { return {{V(splat.color[0]), V(splat.color[1]), V(splat.color[2])}}; }
  void Pixels(State& state, S, int offset, const V&, const Blend<V>& blend) {
    const EntryMaker<E, V> entry(blend);
    L::Store(values[0] + offset, entry.Weight());
    for (int k = 0; k < 3; ++k) {
      V rest = L::Load(behind[k] + offset);
      L::Store(values[1 + k] + offset, entry.Contrast(state.c[k], rest));
      L::Store(behind[k] + offset, rest);
    }
  }
  void End(State&, std::int64_t pair) {
    E* at = entries + kEntryValues * cache.first_entry[pair];
    ForEachVector<V>(cache.masks[pair], [&](int row, int k, std::uint32_t bits) {
      const int n = std::popcount(bits);
      for (const auto& value : values) {
        PackedLanes<E, V>::Store(at, bits, L::Load(value + row * kTileSize + k * L::kWidth));
        at += n;
      }
    });
  }
  void Skip(std::int64_t) {}
};

// Positions of the rows of a tile in the whitened coordinates (p, q) of a splat (types.h): pixel x of row y is at
// (p0[y] + r x, q[y]). TraverseSplats computes the same bits.
template <class V, class S>
struct RowPositions {
  using L = Lanes<V>;
  V r;
  alignas(64) S p0[kTileSize], q[kTileSize];

  // splat: from InTile.
  explicit RowPositions(const Splat<S>& splat) : r(splat.r) {
    const RowSplat<V> all = InAllLanes<V>(splat);
    for (int row = 0; row < kTileSize; row += L::kWidth) {
      const RowPosition<V> place(all, L::Iota() + V(static_cast<S>(row)));
      L::Store(q + row, place.q);
      L::Store(p0 + row, place.p0);
    }
  }
  // The coordinates p of the pixels of vector k of a row.
  V P(int row, int k) const { return OffsetAt(L::Iota() + V(static_cast<S>(k * L::kWidth)), r, V(p0[row])); }
};

// The entries of one vector of pixels, stored at `at`. bits: the pixels with an entry. Unlike Entry, this struct loads
// a number only when it is used, to save registers.
template <class V, class E>
struct PackedEntries {
  const E* at;
  std::uint32_t bits;

  int Size() const { return std::popcount(bits); }
  V Weight() const { return PackedLanes<E, V>::Load(at, bits); }
  V Contrast(int c) const { return PackedLanes<E, V>::Load(at + (c + 1) * Size(), bits); }
  const E* End() const { return at + kEntryValues * Size(); }
};

template <class V, class S>
void MasksOfTile(const TileLists<S>& lists, int tile, TileMask* masks) {
  MaskPass<V, S> pass{masks};
  TraverseSplats<V>(lists, tile, pass);
}

template <class V, class S, class E>
void FillTile(const TileLists<S>& lists, const CacheLists& cache, int tile, const S* image, void* entries) {
  EntryPass<V, S, E> pass;
  pass.cache = cache;
  pass.entries = static_cast<E*>(entries);
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  for (int k = 0; k < 3; ++k) LoadPlane<V>(lists, WindowOf(lists, tile), image + k * plane, pass.behind[k]);
  TraverseSplats<V>(lists, tile, pass);
}

template <class V, class S, class E>
void CachedTangentTile(const TileLists<S>& lists, const CacheLists& cache, const void* entries, int tile,
                       const SplatTangent<S>* tangents, S* d_image) {
  using L = Lanes<V>;
  const TileOrigin<S> origin(lists, tile);
  alignas(64) S d_color[3][kTilePixels] = {};
  const std::int64_t end = lists.tile_begin[tile + 1];
  for (std::int64_t pair = lists.tile_begin[tile]; pair < end; ++pair) {
    // The entries of one tile's pairs are far apart in memory.
    if (pair + kAhead < end) {
      const E* next = static_cast<const E*>(entries) + kEntryValues * cache.first_entry[pair + kAhead];
      for (int line = 0; line < kLinesAhead; ++line) Prefetch(reinterpret_cast<const char*>(next) + 64 * line);
    }
    const std::uint32_t rank = lists.ranks[pair];
    SplatTangent<S> tangent = tangents[rank];
    DivideByEntryScale<E>(tangent);
    const S* w = tangent.w;
    const RowPositions<V, S> places(InTile(lists.splats[rank], origin));
    alignas(64) S linear[kTileSize], constant[kTileSize];  // psi = constant[y] - p (linear[y] + rho p)
    for (int row = 0; row < kTileSize; row += L::kWidth) {
      const V q = L::Load(places.q + row);
      L::Store(linear + row, PsiLinear(V(w[kXi]), V(w[kKappa]), q));
      L::Store(constant + row, PsiConstant(V(w[kZeta]), V(w[kSigma]), V(w[kLambda]), q));
    }
    const V rho(w[kRho]), dc[3] = {V(w[kColor]), V(w[kColor + 1]), V(w[kColor + 2])};
    const E* at = static_cast<const E*>(entries) + kEntryValues * cache.first_entry[pair];
    ForEachVector<V>(cache.masks[pair], [&](int row, int k, std::uint32_t bits) {
      const V psi = Psi(V(linear[row]), V(constant[row]), rho, places.P(row, k));
      const PackedEntries<V, E> entry{at, bits};
      const V weight = entry.Weight();
      for (int c = 0; c < 3; ++c) {
        S* sum = d_color[c] + row * kTileSize + k * L::kWidth;
        L::Store(sum, AddEntry(weight, entry.Contrast(c), psi, dc[c], L::Load(sum)));
      }
      at = entry.End();
    });
  }
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  for (int c = 0; c < 3; ++c) StorePlane<V>(lists, WindowOf(lists, tile), d_color[c], d_image + c * plane);
}

template <class V, class S>
void ToTile(const TileLists<S>& lists, int tile, const S* u, S* u_tiles) {
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  S* to = u_tiles + static_cast<std::int64_t>(tile) * 3 * kTilePixels;
  for (int k = 0; k < 3; ++k) LoadPlane<V>(lists, WindowOf(lists, tile), u + k * plane, to + k * kTilePixels);
}

template <class V, class S, class E>
void CachedAdjointSplats(const TileLists<S>& lists, const CacheLists& cache, const void* entries, std::int64_t begin,
                         std::int64_t end, const S* u_tiles, SplatTangent<S>* sums) {
  using L = Lanes<V>;
  const std::int64_t first = cache.splat_begin[begin], last = cache.splat_begin[end];
  if (first == last) {
    std::fill_n(sums + begin, end - begin, SplatTangent<S>{});
    return;
  }
  const E* at = static_cast<const E*>(entries) + kEntryValues * cache.first_entry[cache.pairs_of_splat[first]];
  for (std::int64_t rank = begin; rank < end; ++rank) {
    const Splat<S>& splat = lists.splats[rank];
    SplatTangent<S> sum{};
    CotangentSums<V> total;
    const auto take_part = [&] {
      SplatTangent<S> part;
      L::template SumEach<kSplatTangent>(total.sum, part.w);
      for (int i = 0; i < kSplatTangent; ++i) sum.w[i] += part.w[i];
      total = {};
    };
    for (std::int64_t e = cache.splat_begin[rank]; e < cache.splat_begin[rank + 1]; ++e) {
      // A partial sum has at most kTermsPerPartialSum terms per lane (types.h). With 16 lanes, a lane has at most one
      // term per row of a tile.
      constexpr int kTilesPerPartialSum = kTermsPerPartialSum / kTileSize;
      const std::int64_t tiles = e - cache.splat_begin[rank];
      if (tiles > 0 && tiles % kTilesPerPartialSum == 0) take_part();
      const std::uint32_t pair = cache.pairs_of_splat[e];
      // Prefetch the masks, which are not contiguous. The entries are.
      if (e + 3 * kAhead < last) Prefetch(&cache.masks[cache.pairs_of_splat[e + 3 * kAhead]]);
      const int tile = static_cast<int>(cache.tiles_of_splat[e]);
      const RowPositions<V, S> places(InTile(splat, TileOrigin<S>(lists, tile)));
      const S* u = u_tiles + static_cast<std::int64_t>(tile) * 3 * kTilePixels;
      ForEachVector<V>(cache.masks[pair], [&](int row, int k, std::uint32_t bits) {
        const S* here = u + row * kTileSize + k * L::kWidth;
        const PackedEntries<V, E> entry{at, bits};
        const V g = AddColors(
            entry, [&](int c) { return L::Load(here + c * kTilePixels); }, total);
        total.AddShape(g, places.P(row, k), V(places.q[row]));
        at = entry.End();
      });
    }
    take_part();
    DivideByEntryScale<E>(sum);
    sums[rank] = sum;
  }
}

// E: number format of the entries.
template <class V, class S, class E>
constexpr CacheKernels<S> MakeCacheKernels() {
  return {&MasksOfTile<V, S>, &FillTile<V, S, E>, &CachedTangentTile<V, S, E>, &ToTile<V, S>,
          &CachedAdjointSplats<V, S, E>};
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
