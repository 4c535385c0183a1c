// SPDX-License-Identifier: Apache-2.0
// The loop of the passes that sum over the pixels of each splat (adjoint, Gram). It visits the splats of a tile front
// to back, and for each splat the vectors of pixels that it may touch. The sums of a splat then stay in registers.
#pragma once

#include <bit>
#include <cstdint>

#include "kernels/gaussian_splatting/formulas/pixel_steps.h"
#include "kernels/gaussian_splatting/tiles/row_span.h"
#include "kernels/gaussian_splatting/tiles/tile_pixels.h"
#include "kernels/math/lanes.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// Position of a splat in each row of a tile, and the vectors of pixels that it touches.
template <class V, class S>
struct SplatRows {
  using L = Lanes<V>;
  static constexpr int kVectors = kTileSize / L::kWidth;
  alignas(64) S q[kTileSize];
  alignas(64) S peak[kTileSize + 1] = {};  // with an extra element without a row
  alignas(64) S p0[kTileSize + 1] = {};    // with an extra element without a row
  std::uint32_t touched[kVectors];         // bit y of touched[k]: the splat touches vector k of row y

  // splat: from InTile.
  void Set(const Splat<S>& splat) {
    const RowSplat<V> all = InAllLanes<V>(splat);
    for (std::uint32_t& rows : touched) rows = 0;
    for (int row = 0; row < kTileSize; row += L::kWidth) {
      const RowSpan<V> span(all, L::Iota() + V(static_cast<S>(row)));
      L::Store(q + row, span.q);
      L::Store(peak + row, span.peak);
      L::Store(p0 + row, span.p0);
      for (int k = 0; k < kVectors; ++k) touched[k] |= span.TouchesVector(k) << row;
    }
  }
};

// Pass has these members:
//
//   State Begin(splat)                      state of one splat, a local object so that it stays in registers
//   Pixels(state, q, offset, p, blend)      processes one vector of pixels; offset: index into the tile
//   End(state, pair), Skip(pair)            pair: position in lists.ranks; Skip replaces both if all pixels are closed
template <class V, class S, class Pass>
[[gnu::always_inline]] inline void TraverseSplats(const TileLists<S>& lists, int tile, Pass& pass) {
  using L = Lanes<V>;
  TilePixels<V, S> pixels(lists, tile);
  const V iota = L::Iota();
  const TileOrigin<S> origin(lists, tile);
  std::int64_t pair = lists.tile_begin[tile];
  const std::int64_t end = lists.tile_begin[tile + 1];
  // Computed one splat ahead, so that the rows to visit are known when the loop over the rows begins.
  SplatRows<V, S> prepared[2];
  const auto prepare = [&](std::int64_t next) {
    prepared[next & 1].Set(InTile(lists.splats[lists.ranks[next]], origin));
  };
  if (pair < end) prepare(pair);
  for (; pair < end && pixels.open_rows() != 0; ++pair) {
    if (pair + 1 < end) prepare(pair + 1);
    const SplatRows<V, S>& rows = prepared[pair & 1];
    const Splat<S>& splat = lists.splats[lists.ranks[pair]];
    typename Pass::State state = pass.Begin(splat);
    const V r(splat.r);
    for (int k = 0; k < pixels.kVectors; ++k) {
      const V columns = iota + V(static_cast<S>(k * L::kWidth));
      std::uint32_t todo = rows.touched[k] & pixels.open[k];
      if (todo == 0) continue;
      // Computed one row ahead, to hide the latency.
      int row = std::countr_zero(todo);
      V p = OffsetAt(columns, r, V(rows.p0[row])), alpha = AlphaAt(p, V(rows.peak[row]));
      do {
        todo &= todo - 1;
        const int next = std::countr_zero(todo | 1U << kTileSize);
        const V next_p = OffsetAt(columns, r, V(rows.p0[next])), next_alpha = AlphaAt(next_p, V(rows.peak[next]));

        const int offset = row * kTileSize + k * L::kWidth;
        S* transmittance = pixels.transmittance + offset;
        const Blend<V> blend = BlendSplat(L::Load(transmittance), alpha);
        L::Store(transmittance, Select(blend.open, blend.transmittance, V(0)));
        if (!L::Any(blend.open)) [[unlikely]]
          pixels.CloseRow(row, k);
        pass.Pixels(state, rows.q[row], offset, p, blend);
        row = next, p = next_p, alpha = next_alpha;
      } while (todo != 0);
    }
    pass.End(state, pair);
  }
  for (; pair < end; ++pair) pass.Skip(pair);
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
