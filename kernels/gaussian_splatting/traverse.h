// The loop that every raster pass shares: the splats of a tile front to back, the rows and vectors of pixels each one
// may touch, alpha and transmittance. A pass adds what it does with one (splat, vector of pixels).
#pragma once

#include <cmath>
#include <cstdint>

#include "kernels/gaussian_splatting/blend.h"

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

// The integers i in [0, kTileSize) with lo <= i <= hi, as [first, last]; empty when first > last. lo and hi are finite.
template <class S>
inline void ClipToTile(S lo, S hi, int& first, int& last) {
  const S limit(kTileSize);
  const S a = lo < S(0) ? S(0) : (lo > limit ? limit : lo);
  const S b = hi < S(-1) ? S(0) : (hi > limit - S(1) ? limit : hi + S(1));
  first = static_cast<int>(a);
  first += static_cast<S>(first) < a ? 1 : 0;
  last = static_cast<int>(b) - 1;
}

// For each row of a tile the support of one splat, in pixel centres relative to the tile's first.
template <class S>
struct SplatRows {
  alignas(64) S q[kTileSize];                  // whitened vertical offset
  alignas(64) S centre[kTileSize];             // where p = 0
  alignas(64) S lo[kTileSize], hi[kTileSize];  // columns it may reach, clipped to the tile; lo > hi where none
};

// u, v: the splat's mean relative to the centre of the tile's first pixel. Fills rows first..last, rounded outwards to
// whole vectors.
template <class V, class S>
inline void ComputeRows(const Splat<S>& splat, S u, S v, int first, int last, SplatRows<S>& rows) {
  using std::sqrt;
  using L = Lanes<V>;
  const V iota = L::Iota(), inv_r(S(1) / splat.r), s(splat.s), beta(splat.beta), support(splat.support);
  const V none_lo(static_cast<S>(kTileSize)), none_hi(static_cast<S>(-1));
  for (int row = first / L::kWidth * L::kWidth; row <= last; row += L::kWidth) {
    const V dy = iota + V(static_cast<S>(row) - v);
    const V q = s * dy;
    const V rest = support - q * q;
    const V centre = V(u) - beta * dy;
    const V half_width = sqrt(Max(rest, V(0))) * inv_r;
    const auto meets = rest > V(0);
    L::Store(rows.q + row, q);
    L::Store(rows.centre + row, centre);
    L::Store(rows.lo + row, Select(meets, Max(centre - half_width, V(0)), none_lo));
    L::Store(rows.hi + row, Select(meets, Min(centre + half_width, V(static_cast<S>(kTileSize - 1))), none_hi));
  }
}

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
//   BeginSplat(rank, splat), BeginRow(q),
//   Pixels(offset, p, alpha, counts, transmittance)   transmittance in front of the splat; offset into the tile
//   EndRow(), EndSplat(pair), Skip(pair)               pair: position in lists.ranks; Skip where all pixels are closed
// At the end transmittance[i] is what passes all splats, positive for pixels of the image.
//
// Always inlined, or the sums that a pass keeps for one splat live in memory instead of registers.
template <class V, class S, class Pass>
[[gnu::always_inline]] inline void TraverseTile(const TileLists<S>& lists, int tile, Pass& pass, S* transmittance) {
  using L = Lanes<V>;
  constexpr int kVectors = kTileSize / L::kWidth;
  const TileWindow window = WindowOf(lists, tile);
  bool open[kTileSize * kVectors];
  int num_open = 0;
  for (int y = 0; y < kTileSize; ++y) {
    for (int x = 0; x < kTileSize; ++x) {
      transmittance[y * kTileSize + x] = x < window.width && y < window.height ? S(1) : S(-1);
    }
    for (int k = 0; k < kVectors; ++k) {
      open[y * kVectors + k] = y < window.height && k * L::kWidth < window.width;
      num_open += open[y * kVectors + k] ? 1 : 0;
    }
  }
  const V iota = L::Iota();
  const S half(0.5);
  SplatRows<S> rows;
  std::int64_t pair = lists.tile_begin[tile];
  const std::int64_t end = lists.tile_begin[tile + 1];
  for (; pair < end && num_open > 0; ++pair) {
    const std::uint32_t rank = lists.ranks[pair];
    const Splat<S>& splat = lists.splats[rank];
    pass.BeginSplat(rank, splat);
    const S u = splat.u - (static_cast<S>(window.x0) + half), v = splat.v - (static_cast<S>(window.y0) + half);
    const S reach = std::sqrt(splat.support) / splat.s;
    int row, last_row;
    ClipToTile(v - reach, v + reach, row, last_row);
    ComputeRows<V>(splat, u, v, row, last_row, rows);
    const V r(splat.r), opacity(splat.opacity);
    for (; row <= last_row; ++row) {
      const S lo = rows.lo[row], hi = rows.hi[row];
      if (!(lo <= hi)) continue;
      const int first = static_cast<int>(lo), last = static_cast<int>(hi);
      const S q = rows.q[row];
      const V half_q2(half * q * q), left(rows.centre[row]);
      pass.BeginRow(q);
      for (int k = first / L::kWidth; k <= last / L::kWidth; ++k) {
        if (!open[row * kVectors + k]) continue;
        const V p = (iota + V(static_cast<S>(k * L::kWidth)) - left) * r;
        const Alpha<V> alpha = EvaluateAlpha(p, half_q2, opacity);
        if (!Any(alpha.counts)) continue;
        const int offset = row * kTileSize + k * L::kWidth;
        const V before = L::Load(transmittance + offset);
        const BlendResult<V> blended = Blend(before, alpha);
        L::Store(transmittance + offset, blended.transmittance);
        pass.Pixels(offset, p, alpha, blended.counts, before);
        if (!Any(blended.transmittance > V(0))) {
          open[row * kVectors + k] = false;
          --num_open;
        }
      }
      pass.EndRow();
    }
    pass.EndSplat(pair);
  }
  for (; pair < end; ++pair) pass.Skip(pair);
  for (int i = 0; i < kTilePixels; ++i) {
    if (transmittance[i] < S(0)) transmittance[i] = -transmittance[i];
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
