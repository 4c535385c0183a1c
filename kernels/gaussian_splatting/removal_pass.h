// The raster pass of removal.h over one tile.
#pragma once

#include <cmath>

#include "kernels/gaussian_splatting/removal.h"
#include "kernels/gaussian_splatting/traverse_splats.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// The share of a splat's energy that a window leaves, by its conic: 2 ln 2 times the square of what maps d to (p, q).
template <class S>
VESTA_HD inline S EnergyUnderWindow(const Splat<S>& splat, S variance) {
  const S scale = static_cast<S>(kTwoLn2) * variance, r2 = splat.r * splat.r, s2 = splat.s * splat.s;
  const S trace = r2 * (S(1) + splat.beta * splat.beta) + s2;
  return S(1) / std::sqrt(S(1) + scale * (trace + scale * r2 * s2));
}

template <class V, class S>
struct RemovalPass {
  using L = Lanes<V>;
  Removal<S>* sums;
  RemovalLoss<S> loss;
  alignas(64) S behind[3][kTilePixels];  // S of pixel_steps.h
  alignas(64) S error[3][kTilePixels], gradient[3][kTilePixels], diagonal[3][kTilePixels], curvature[3][kTilePixels];

  struct State {
    V c[3], left_by_window;
    V sum[kRemovalSums];
  };
  State Begin(const Splat<S>& splat) const {
    return {{V(splat.color[0]), V(splat.color[1]), V(splat.color[2])},
            V(loss.ssim * EnergyUnderWindow(splat, loss.window_variance)),
            {V(0), V(0)}};
  }
  void Pixels(State& state, S, int offset, const V&, const Blend<V>& blend) {
    const V odds = Odds(blend.alpha);
    V rise(0);
    for (int k = 0; k < 3; ++k) {
      const V share = blend.weight * state.c[k];
      const V rest = L::Load(behind[k] + offset) - share;
      L::Store(behind[k] + offset, rest);
      const V delta = Fma(rest, odds, -share), e = L::Load(error[k] + offset);
      const PixelPenalty<V> with(e, loss.penalty), without(e + delta, loss.penalty);
      const V l1(loss.l1);
      const V slope = Fnma(l1, with.derivative, L::Load(gradient[k] + offset));  // of SSIM alone, as is the curvature
      const V pointwise = Fnma(l1, with.Curvature(loss.penalty), L::Load(diagonal[k] + offset));
      const V bend = Fma(state.left_by_window, L::Load(curvature[k] + offset), pointwise);
      rise = Fma(l1, without.value - with.value, Fma(delta, Fma(V(S(0.5)) * bend, delta, slope), rise));
    }
    state.sum[0] = state.sum[0] + Select(blend.alpha > V(0), rise, V(0));
    state.sum[1] = state.sum[1] + blend.weight;
  }
  void End(State& state, std::int64_t pair) {
    S out[kRemovalSums];
    L::template SumEach<kRemovalSums>(state.sum, out);
    sums[pair] = {out[0], out[1]};
  }
  void Skip(std::int64_t pair) { sums[pair] = {}; }
};

template <class V, class S>
void RemovalTile(const TileLists<S>& lists, int tile, const RemovalLoss<S>& loss, Removal<S>* pair_sums) {
  RemovalPass<V, S> pass;
  pass.sums = pair_sums;
  pass.loss = loss;
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  const TileWindow window = WindowOf(lists, tile);
  alignas(64) S truth[kTilePixels];
  for (int k = 0; k < 3; ++k) {
    LoadPlane<V>(lists, window, loss.rendered + k * plane, pass.behind[k]);
    LoadPlane<V>(lists, window, loss.truth + k * plane, truth);
    for (int i = 0; i < kTilePixels; ++i) pass.error[k][i] = pass.behind[k][i] - truth[i];
    LoadPlane<V>(lists, window, loss.gradient + k * plane, pass.gradient[k]);
    LoadPlane<V>(lists, window, loss.diagonal + k * plane, pass.diagonal[k]);
    LoadPlane<V>(lists, window, loss.curvature + k * plane, pass.curvature[k]);
  }
  TraverseSplats<V>(lists, tile, pass);
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
