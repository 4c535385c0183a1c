// The loop that every raster pass shares: the splats of a tile front to back, the vectors of pixels each one may touch,
// alpha and transmittance. A pass adds what it does with one (splat, vector of pixels).
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "kernels/gaussian_splatting/pixel_steps.h"
#include "kernels/math/lanes.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

inline constexpr int kTilePixels = kTileSize * kTileSize;

// Where a tile lies in the image.
struct TileWindow {
  int x0, y0;         // first pixel
  int width, height;  // pixels inside the image, 1..16 each
};

template <class S>
inline TileWindow WindowOf(const TileLists<S>& lists, int tile) {
  const int x0 = tile % lists.tiles_x * kTileSize, y0 = tile / lists.tiles_x * kTileSize;
  const int w = lists.width - x0, h = lists.height - y0;
  return {x0, y0, w < kTileSize ? w : kTileSize, h < kTileSize ? h : kTileSize};
}

// Where one splat may reach in a tile: row by row its place, and the rows it meets in each column of vectors.
template <class V, class S>
struct SplatRows {
  using L = Lanes<V>;
  static constexpr int kVectors = kTileSize / L::kWidth;
  alignas(64) S q[kTileSize];              // vertical offset in whitened coordinates
  alignas(64) S peak[kTileSize + 1] = {};  // log2 of the opacity, less q^2; and one more, of no row
  alignas(64) S p0[kTileSize + 1] = {};    // p at column 0; likewise
  std::uint32_t meets[kVectors];           // bit y of meets[k]: row y, pixels k * width and on

  // u, v: the splat's mean relative to the centre of the tile's first pixel.
  void Set(const Splat<S>& splat, S u, S v) {
    using std::ceil, std::floor, std::sqrt;
    const V iota = L::Iota(), s(splat.s), beta(splat.beta), support(splat.support), inv_r(splat.inv_r), r(splat.r),
            mean(u), log2_opacity(splat.log2_opacity);
    for (std::uint32_t& rows : meets) rows = 0;
    for (int row = 0; row < kTileSize; row += L::kWidth) {
      const V dy = iota + V(static_cast<S>(row) - v);
      const SplatRow<V> place = PlaceRow(r, s, beta, log2_opacity, support, mean, dy);
      const V half_width = sqrt(Max(place.rest, V(0))) * inv_r;
      // The first and the last pixel within reach, so that rows between two pixels are left out.
      const V first = ceil(place.middle - half_width), last = floor(place.middle + half_width);
      L::Store(q + row, place.q);
      L::Store(peak + row, place.peak);
      L::Store(p0 + row, place.p0);
      const auto reaches = place.rest > V(0);
      for (int k = 0; k < kVectors; ++k) {
        const V from(static_cast<S>(k * L::kWidth)), to(static_cast<S>(k * L::kWidth + L::kWidth - 1));
        meets[k] |= L::Bits(reaches & (Max(first, from) <= Min(last, to))) << row;
      }
    }
  }
};

// Copies one plane of a planar image into a tile (row stride 16, zero outside the image), and back.
template <class S>
inline void LoadPlane(const TileLists<S>& lists, const TileWindow& window, const S* plane, S* tile) {
  for (int i = 0; i < kTilePixels; ++i) tile[i] = S(0);
  for (int y = 0; y < window.height; ++y) {
    const S* row = plane + static_cast<std::int64_t>(window.y0 + y) * lists.width + window.x0;
    for (int x = 0; x < window.width; ++x) tile[y * kTileSize + x] = row[x];
  }
}
template <class S>
inline void StorePlane(const TileLists<S>& lists, const TileWindow& window, const S* tile, S* plane) {
  for (int y = 0; y < window.height; ++y) {
    S* row = plane + static_cast<std::int64_t>(window.y0 + y) * lists.width + window.x0;
    for (int x = 0; x < window.width; ++x) row[x] = tile[y * kTileSize + x];
  }
}

// Pass has
//   State Begin(rank, splat)                what it keeps for one splat, a local object so that it lives in registers
//   Pixels(state, q, offset, p, blend)      one vector of pixels; offset into the tile
//   End(state, pair), Skip(pair)            pair: position in lists.ranks; Skip where all pixels are closed
// At the end transmittance[i] is what passes all splats.
template <class V, class S, class Pass>
[[gnu::always_inline]] inline void TraverseTile(const TileLists<S>& lists, int tile, Pass& pass, S* transmittance) {
  using L = Lanes<V>;
  constexpr int kVectors = SplatRows<V, S>::kVectors;
  const TileWindow window = WindowOf(lists, tile);
  // What passes the splats so far, 0 where the pixel is closed; transmittance[] keeps what passed when it closed.
  alignas(64) S ahead[kTilePixels];
  std::uint32_t open[kVectors] = {};  // bit y: a pixel of row y is open
  for (int y = 0; y < kTileSize; ++y) {
    for (int x = 0; x < kTileSize; ++x) {
      ahead[y * kTileSize + x] = x < window.width && y < window.height ? S(1) : S(0);
      transmittance[y * kTileSize + x] = S(0);
    }
    for (int k = 0; k < kVectors; ++k) {
      if (y < window.height && k * L::kWidth < window.width) open[k] |= 1U << y;
    }
  }
  const V iota = L::Iota();
  const S left = static_cast<S>(window.x0) + S(0.5), top = static_cast<S>(window.y0) + S(0.5);
  std::int64_t pair = lists.tile_begin[tile];
  const std::int64_t end = lists.tile_begin[tile + 1];
  // One splat ahead, so that the rows to visit are known when the loop over them begins.
  SplatRows<V, S> prepared[2];
  const auto prepare = [&](std::int64_t next) {
    const Splat<S>& splat = lists.splats[lists.ranks[next]];
    prepared[next & 1].Set(splat, splat.u - left, splat.v - top);
  };
  if (pair < end) prepare(pair);
  for (; pair < end; ++pair) {
    std::uint32_t any_open = 0;
    for (const std::uint32_t mask : open) any_open |= mask;
    if (any_open == 0) break;
    if (pair + 1 < end) prepare(pair + 1);
    const SplatRows<V, S>& rows = prepared[pair & 1];
    const std::uint32_t rank = lists.ranks[pair];
    const Splat<S>& splat = lists.splats[rank];
    typename Pass::State state = pass.Begin(rank, splat);
    const V r(splat.r);
    for (int k = 0; k < kVectors; ++k) {
      const V columns = iota + V(static_cast<S>(k * L::kWidth));
      std::uint32_t todo = rows.meets[k] & open[k];
      if (todo == 0) continue;
      // alpha one row ahead of what uses it: its latency would otherwise fill the processor's queue of instructions.
      int row = std::countr_zero(todo);
      V p = OffsetAt(columns, r, V(rows.p0[row])), alpha = AlphaAt(p, V(rows.peak[row]));
      do {
        todo &= todo - 1;
        const int next = std::countr_zero(todo | 1U << kTileSize);
        const V next_p = OffsetAt(columns, r, V(rows.p0[next])), next_alpha = AlphaAt(next_p, V(rows.peak[next]));

        const int offset = row * kTileSize + k * L::kWidth;
        const V before = L::Load(ahead + offset);
        Blend<V> blend = BlendSplat(before, alpha);
        if (L::Any(blend.closes)) [[unlikely]] {
          Close(blend);
          L::Store(transmittance + offset, Select(blend.closes, before, L::Load(transmittance + offset)));
          if (!L::Any(blend.transmittance > V(0))) open[k] &= ~(1U << row);
        }
        L::Store(ahead + offset, blend.transmittance);
        pass.Pixels(state, rows.q[row], offset, p, blend);
        row = next, p = next_p, alpha = next_alpha;
      } while (todo != 0);
    }
    pass.End(state, pair);
  }
  for (; pair < end; ++pair) pass.Skip(pair);
  for (int i = 0; i < kTilePixels; ++i) transmittance[i] += ahead[i];
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
