// The passes bound to images: what RasterKernels points to.
#pragma once

#include "kernels/gaussian_splatting/passes.h"
#include "kernels/gaussian_splatting/raster_kernels.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

template <class V, class S>
void ForwardTile(const TileLists<S>& lists, int tile, S* image) {
  alignas(64) S transmittance[kTilePixels];
  ForwardPass<V, S> pass;
  TraverseTile<V>(lists, tile, pass, transmittance);
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < kTilePixels; ++i) pass.color[k][i] += transmittance[i] * lists.background[k];
    StorePlane(lists, WindowOf(lists, tile), pass.color[k], image + k * plane);
  }
}

template <class V, class S>
void TangentTile(const TileLists<S>& lists, int tile, const SplatTangent<S>* tangents, S* d_image) {
  alignas(64) S transmittance[kTilePixels];
  TangentPass<V, S> pass;
  pass.tangents = tangents;
  TraverseTile<V>(lists, tile, pass, transmittance);
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < kTilePixels; ++i) pass.d_color[k][i] -= pass.minus_dT[i] * lists.background[k];
    StorePlane(lists, WindowOf(lists, tile), pass.d_color[k], d_image + k * plane);
  }
}

template <class V, class S>
void AdjointTile(const TileLists<S>& lists, int tile, const S* image, const S* u, SplatTangent<S>* pair_sums) {
  alignas(64) S transmittance[kTilePixels], color[kTilePixels];
  AdjointPass<V, S> pass;
  pass.sums = pair_sums;
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  const TileWindow window = WindowOf(lists, tile);
  for (int i = 0; i < kTilePixels; ++i) pass.behind[i] = S(0);
  for (int k = 0; k < 3; ++k) {
    LoadPlane(lists, window, u + k * plane, pass.u[k]);
    LoadPlane(lists, window, image + k * plane, color);
    for (int i = 0; i < kTilePixels; ++i) pass.behind[i] += pass.u[k][i] * color[i];
  }
  TraverseTile<V>(lists, tile, pass, transmittance);
}

template <class V, class S>
void GramTile(const TileLists<S>& lists, int tile, const S* image, const S* omega, SplatGram<S>* pair_sums) {
  alignas(64) S transmittance[kTilePixels];
  GramPass<V, S> pass;
  pass.sums = pair_sums;
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  const TileWindow window = WindowOf(lists, tile);
  for (int k = 0; k < 3; ++k) {
    LoadPlane(lists, window, omega + k * plane, pass.omega[k]);
    LoadPlane(lists, window, image + k * plane, pass.behind[k]);
  }
  TraverseTile<V>(lists, tile, pass, transmittance);
}

template <class V, class S>
VisitCounts CountTile(const TileLists<S>& lists, int tile) {
  alignas(64) S transmittance[kTilePixels];
  CountPass<V, S> pass;
  TraverseTile<V>(lists, tile, pass, transmittance);
  return pass.counts;
}

template <class V, class S>
RasterKernels<S> MakeRasterKernels() {
  return {&ForwardTile<V, S>, &TangentTile<V, S>, &AdjointTile<V, S>, &GramTile<V, S>, &CountTile<V, S>};
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
