// SPDX-License-Identifier: Apache-2.0
// The functions in RasterKernels: load the pixels of a tile, run a pass (passes.h, loss_passes.h) and store the result.
#pragma once

#include "kernels/gaussian_splatting/raster/loss_passes.h"
#include "kernels/gaussian_splatting/raster/passes.h"
#include "kernels/gaussian_splatting/raster/raster_kernels.h"

namespace vesta::splat {

inline namespace VESTA_ISA {

template <class S>
void PrefetchImage(const TileLists<S>& lists, const TileWindow& window, const S* image) {
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  for (int k = 0; k < 3; ++k) PrefetchPlane(lists, window, image + k * plane);
}

// Stores the pass's colours plus the background.
template <class V, class S, class Pass>
void StoreImage(const TileLists<S>& lists, const TileWindow& window, Pass& pass, S* image) {
  using L = Lanes<V>;
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  for (int k = 0; k < 3; ++k) {
    alignas(64) S pixels[kTilePixels];
    for (int i = 0; i < kTilePixels; i += L::kWidth)
      L::Store(pixels + i, pass.WithBackground(V(lists.background[k]), k, i));
    StorePlane<V>(lists, window, pixels, image + k * plane);
  }
}

template <class V, class S>
void ForwardTile(const TileLists<S>& lists, int tile, S* image) {
  const TileWindow window = WindowOf(lists, tile);
  TilePixels<V, S> pixels(lists, tile);
  ForwardPass<V, S> pass;
  PrefetchImage(lists, window, image);
  TraverseRows<V>(lists, tile, pixels, pass);
  StoreImage<V, S>(lists, window, pass, image);
}

template <class V, class S>
void TangentTile(const TileLists<S>& lists, int tile, const SplatTangent<S>* tangents, S* d_image) {
  const TileWindow window = WindowOf(lists, tile);
  TilePixels<V, S> pixels(lists, tile);
  TangentPass<V, S> pass(tangents);
  PrefetchImage(lists, window, d_image);
  TraverseRows<V>(lists, tile, pixels, pass);
  StoreImage<V, S>(lists, window, pass, d_image);
}

template <class V, class S>
void ForwardTangentTile(const TileLists<S>& lists, int tile, const SplatTangent<S>* tangents, S* image, S* d_image) {
  const TileWindow window = WindowOf(lists, tile);
  TilePixels<V, S> pixels(lists, tile);
  BothPasses<ForwardPass<V, S>, TangentPass<V, S>> pass{{}, TangentPass<V, S>(tangents)};
  PrefetchImage(lists, window, image);
  PrefetchImage(lists, window, d_image);
  TraverseRows<V>(lists, tile, pixels, pass);
  StoreImage<V, S>(lists, window, pass.first, image);
  StoreImage<V, S>(lists, window, pass.second, d_image);
}

template <class V, class S>
void AdjointTile(const TileLists<S>& lists, int tile, const S* image, const S* u, SplatTangent<S>* pair_sums) {
  using L = Lanes<V>;
  alignas(64) S color[kTilePixels];
  AdjointPass<V, S> pass;
  pass.sums = pair_sums;
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  const TileWindow window = WindowOf(lists, tile);
  SetZero<V>(pass.behind);
  for (int k = 0; k < 3; ++k) {
    LoadPlane<V>(lists, window, u + k * plane, pass.u[k]);
    LoadPlane<V>(lists, window, image + k * plane, color);
    for (int i = 0; i < kTilePixels; i += L::kWidth) {
      L::Store(pass.behind + i, Fma(L::Load(pass.u[k] + i), L::Load(color + i), L::Load(pass.behind + i)));
    }
  }
  TraverseSplats<V>(lists, tile, pass);
}

template <class V, class S>
void GramTile(const TileLists<S>& lists, int tile, const S* image, const S* omega, SplatGram<S>* pair_sums) {
  GramPass<V, S> pass;
  pass.sums = pair_sums;
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  const TileWindow window = WindowOf(lists, tile);
  for (int k = 0; k < 3; ++k) {
    LoadPlane<V>(lists, window, omega + k * plane, pass.omega[k]);
    LoadPlane<V>(lists, window, image + k * plane, pass.behind[k]);
  }
  TraverseSplats<V>(lists, tile, pass);
}

template <class V, class S>
VisitCounts CountTile(const TileLists<S>& lists, int tile) {
  TilePixels<V, S> pixels(lists, tile);
  CountPass<V, S> pass;
  TraverseRows<V>(lists, tile, pixels, pass);
  return pass.counts;
}

template <class V, class S>
RasterKernels<S> MakeRasterKernels() {
  return {&ForwardTile<V, S>, &TangentTile<V, S>,        &ForwardTangentTile<V, S>, &AdjointTile<V, S>, &GramTile<V, S>,
          &RemovalTile<V, S>, &ColorCurvatureTile<V, S>, &RecolorTile<V, S>,        &CountTile<V, S>};
}

// Each pixel gets the values of the splat at which its transmittance falls below one half.
template <class V, class S>
struct MedianPass {
  using L = Lanes<V>;
  const SplatTangent<S>* values;
  alignas(64) S chosen[3][kTilePixels];
  alignas(64) S transmittance[kTilePixels];
  struct {
    S color[3], pad;
  } of[RowBatch<V, S>::kPlaces];

  struct State {
    V chosen[3], transmittance;
  };
  explicit MedianPass(const SplatTangent<S>* splat_values) : values(splat_values) {
    for (S* plane : chosen) SetZero<V>(plane);
    for (S& t : transmittance) t = S(1);
  }
  void Prepare(int place, const Splat<S>&, std::uint32_t rank) {
    for (int k = 0; k < 3; ++k) of[place].color[k] = values[rank].w[kColor + k];
  }
  void PrepareRow(int, const V&) {}
  State Load(int offset) const {
    return {{L::Load(chosen[0] + offset), L::Load(chosen[1] + offset), L::Load(chosen[2] + offset)},
            L::Load(transmittance + offset)};
  }
  void Store(const State& state, int offset) {
    for (int k = 0; k < 3; ++k) L::Store(chosen[k] + offset, state.chosen[k]);
    L::Store(transmittance + offset, state.transmittance);
  }
  void Pixels(State& state, std::uint32_t place, const V&, const Blend<V>& blend) {
    const V half(S(0.5));
    const auto is_before = state.transmittance >= half, is_behind = blend.transmittance < half;
    for (int k = 0; k < 3; ++k) {
      const V here = Select(is_before, V(of[place].color[k]), state.chosen[k]);
      state.chosen[k] = Select(is_behind, here, state.chosen[k]);
    }
    state.transmittance = blend.transmittance;
  }
  V WithBackground(const V&, int channel, int offset) const { return L::Load(chosen[channel] + offset); }
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
