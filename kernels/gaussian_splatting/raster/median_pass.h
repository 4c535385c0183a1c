// SPDX-License-Identifier: Apache-2.0
// The pass that blends nothing: of all splats of a pixel it takes the one at which the transmittance falls below a
// half.
#pragma once

#include "kernels/gaussian_splatting/raster/raster_tile.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

template <class V, class S>
struct MedianPass {
  using L = Lanes<V>;
  const SplatTangent<S>* values;
  alignas(64) S taken[3][kTilePixels];
  alignas(64) S transmittance[kTilePixels];
  struct {
    S color[3], pad;
  } of[RowBatch<V, S>::kPlaces];

  struct State {
    V taken[3], transmittance;
  };
  explicit MedianPass(const SplatTangent<S>* splat_values) : values(splat_values) {
    for (S* plane : taken) SetZero<V>(plane);
    for (S& t : transmittance) t = S(1);
  }
  void Prepare(int place, const Splat<S>&, std::uint32_t rank) {
    for (int k = 0; k < 3; ++k) of[place].color[k] = values[rank].w[kColor + k];
  }
  void PrepareRow(int, const V&) {}
  State Load(int offset) const {
    return {{L::Load(taken[0] + offset), L::Load(taken[1] + offset), L::Load(taken[2] + offset)},
            L::Load(transmittance + offset)};
  }
  void Store(const State& state, int offset) {
    for (int k = 0; k < 3; ++k) L::Store(taken[k] + offset, state.taken[k]);
    L::Store(transmittance + offset, state.transmittance);
  }
  void Pixels(State& state, std::uint32_t place, const V&, const Blend<V>& blend) {
    const V half(S(0.5));
    const auto is_before = state.transmittance >= half, is_behind = blend.transmittance < half;
    for (int k = 0; k < 3; ++k) {
      const V here = Select(is_before, V(of[place].color[k]), state.taken[k]);
      state.taken[k] = Select(is_behind, here, state.taken[k]);
    }
    state.transmittance = blend.transmittance;
  }
  V Over(const V&, int channel, int offset) const { return L::Load(taken[channel] + offset); }
};

template <class V, class S>
void MedianTile(const TileLists<S>& lists, int tile, const SplatTangent<S>* values, S* planes) {
  TilePixels<V, S> pixels(lists, tile);
  MedianPass<V, S> pass(values);
  TraverseRows<V>(lists, tile, pixels, pass);
  StoreImage<V, S>(lists, WindowOf(lists, tile), pass, planes);
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
