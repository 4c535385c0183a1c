// SPDX-License-Identifier: Apache-2.0
// The loop of the passes that sum over splats (image, tangent). It visits the splats of a tile in batches, front to
// back, and processes each batch row by row. The sums of a vector of pixels then stay in registers for the whole batch.
#pragma once

#include <bit>
#include <cstdint>

#include "kernels/gaussian_splatting/formulas/pixel_steps.h"
#include "kernels/gaussian_splatting/tiles/row_span.h"
#include "kernels/gaussian_splatting/tiles/tile_pixels.h"
#include "kernels/math/lanes.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// A batch of consecutive splats of a tile, as a structure of arrays. It fits into the first-level cache. The place of a
// splat is its index in the batch.
template <class V, class S>
class RowBatch {
 public:
  using L = Lanes<V>;
  static constexpr int kSplats = 128;
  static constexpr int kPlaces = kSplats + 16;  // places after the last splat are empty
  static constexpr int kVectors = kTileSize / L::kWidth;

  int size = 0;

  // Adds a splat from InTile.
  void Add(const Splat<S>& splat) {
    u_[size] = splat.u, v_[size] = splat.v;
    r_[size] = splat.r, s_[size] = splat.s, beta_[size] = splat.beta;
    log2_opacity_[size] = splat.log2_opacity, support_[size] = splat.support, inv_r_[size] = splat.inv_r;
    ++size;
  }
  // Fills the last vector with splats that cover no pixel.
  void Pad() {
    for (int i = size; i % L::kWidth != 0; ++i) {
      u_[i] = v_[i] = r_[i] = s_[i] = beta_[i] = log2_opacity_[i] = inv_r_[i] = S(0), support_[i] = S(-1);
    }
  }

  // Computes the position of each splat in row y of the tile, and for each vector of pixels the splats that touch it.
  // Calls row_done(first place, q) for each vector of splats.
  template <class RowDone>
  void SetRow(int y, const RowDone& row_done) {
    for (int& count : num_touching_) count = 0;
    for (int i = 0; i < size; i += L::kWidth) {
      const RowSplat<V> splats{L::Load(u_ + i),       L::Load(v_ + i),    L::Load(r_ + i),
                               L::Load(s_ + i),       L::Load(beta_ + i), L::Load(log2_opacity_ + i),
                               L::Load(support_ + i), L::Load(inv_r_ + i)};
      const RowSpan<V> span(splats, V(static_cast<S>(y)));
      L::Store(peak_ + i, span.peak);
      L::Store(p0_ + i, span.p0);
      for (int k = 0; k < kVectors; ++k) {
        num_touching_[k] +=
            AppendSetBits(span.TouchesVector(k), static_cast<std::uint32_t>(i), touching_[k] + num_touching_[k]);
      }
      row_done(i, span.q);
    }
    for (int k = 0; k < kVectors; ++k) touching_[k][num_touching_[k]] = touching_[k][num_touching_[k] + 1] = kSplats;
  }
  // For the current row: the number of splats that touch vector k of pixels, and their places, followed by two empty
  // places.
  int num_touching(int k) const { return num_touching_[k]; }
  const std::uint32_t* touching(int k) const { return touching_[k]; }
  V P(std::uint32_t splat, const V& columns) const { return OffsetAt(columns, V(r_[splat]), V(p0_[splat])); }
  V Exponent(std::uint32_t splat, const V& p) const { return ExponentAt(p, V(peak_[splat])); }

 private:
  alignas(64) S u_[kSplats], v_[kSplats], r_[kSplats + 1] = {}, s_[kSplats], beta_[kSplats],
                                                       log2_opacity_[kSplats], support_[kSplats], inv_r_[kSplats];
  alignas(64) S peak_[kPlaces] = {}, p0_[kPlaces] = {};  // of the current row
  int num_touching_[kVectors];
  std::uint32_t touching_[kVectors][kPlaces];
};

// Pass has these members:
//
//   Prepare(place, splat, rank)               stores the data of a splat that the pass needs, at its place in the batch
//   PrepareRow(first place, q)                prepares one vector of splats for one row
//   State Load(offset), Store(state, offset)  state of a vector of pixels; offset: index into the tile
//   Pixels(state, place, p, blend)            processes one vector of pixels
template <class V, class S, class Pass>
[[gnu::always_inline]] inline void TraverseRows(const TileLists<S>& lists, int tile, TilePixels<V, S>& pixels,
                                                Pass& pass) {
  using L = Lanes<V>;
  const V iota = L::Iota();
  const TileOrigin<S> origin(lists, tile);
  std::int64_t pair = lists.tile_begin[tile];
  const std::int64_t end = lists.tile_begin[tile + 1];
  RowBatch<V, S> batch;
  while (pair < end && pixels.open_rows() != 0) {
    for (batch.size = 0; pair < end && batch.size < batch.kSplats; ++pair) {
      const std::uint32_t rank = lists.ranks[pair];
      __builtin_prefetch(&lists.splats[lists.ranks[pair + 8 < end ? pair + 8 : pair]]);
      pass.Prepare(batch.size, lists.splats[rank], rank);
      batch.Add(InTile(lists.splats[rank], origin));
    }
    batch.Pad();
    for (std::uint32_t rows = pixels.open_rows(); rows != 0; rows &= rows - 1) {
      const int y = std::countr_zero(rows);
      batch.SetRow(y, [&](int first, const V& q) { pass.PrepareRow(first, q); });
      for (int k = 0; k < batch.kVectors; ++k) {
        const int count = batch.num_touching(k);
        if (count == 0 || (pixels.open[k] >> y & 1U) == 0) continue;
        const std::uint32_t* places = batch.touching(k);
        const int offset = y * kTileSize + k * L::kWidth;
        const V columns = iota + V(static_cast<S>(k * L::kWidth));
        V transmittance = L::Load(pixels.transmittance + offset);
        typename Pass::State state = pass.Load(offset);
        // The exponent is computed two splats ahead and alpha one splat ahead, to hide their latency.
        V p = batch.P(places[0], columns), alpha = EvaluateAlpha(batch.Exponent(places[0], p));
        V next_p = batch.P(places[1], columns), exponent = batch.Exponent(places[1], next_p);
        for (int i = 0; i < count; ++i) {
          const V after_p = batch.P(places[i + 2], columns), after_exponent = batch.Exponent(places[i + 2], after_p);
          const V next_alpha = EvaluateAlpha(exponent);
          const Blend<V> blend = BlendSplat(transmittance, alpha);
          transmittance = blend.transmittance;
          pass.Pixels(state, places[i], p, blend);
          if (!L::Any(blend.open)) [[unlikely]] {
            pixels.CloseRow(y, k);
            break;
          }
          p = next_p, alpha = next_alpha, next_p = after_p, exponent = after_exponent;
        }
        const auto open = transmittance >= V(static_cast<S>(kTransmittanceStop));
        L::Store(pixels.transmittance + offset, Select(open, transmittance, V(0)));
        pass.Store(state, offset);
      }
    }
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
