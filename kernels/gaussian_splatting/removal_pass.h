// The raster pass of removal.h over one tile.
#pragma once

#include "kernels/gaussian_splatting/loss_of_change.h"
#include "kernels/gaussian_splatting/removal.h"
#include "kernels/gaussian_splatting/traverse_splats.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

template <class V, class S>
struct RemovalPass {
  using L = Lanes<V>;
  Removal<S>* sums;
  LossOfChange<V, S> loss;
  alignas(64) S behind[3][kTilePixels];  // S of pixel_steps.h

  struct State {
    V c[3], left_by_window;
    V sum[kRemovalSums];
  };
  State Begin(const Splat<S>& splat) const {
    return {{V(splat.color[0]), V(splat.color[1]), V(splat.color[2])}, loss.LeftByWindow(splat), {V(0), V(0)}};
  }
  void Pixels(State& state, S, int offset, const V&, const Blend<V>& blend) {
    const V odds = Odds(blend.alpha);
    V rise(0);
    for (int k = 0; k < 3; ++k) {
      const V share = blend.weight * state.c[k];
      const V rest = L::Load(behind[k] + offset) - share;
      L::Store(behind[k] + offset, rest);
      loss.AddRise(k, offset, Fma(rest, odds, -share), state.left_by_window, rise);
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
void RemovalTile(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss, Removal<S>* pair_sums) {
  RemovalPass<V, S> pass;
  pass.sums = pair_sums;
  pass.loss.loss = loss;
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  const TileWindow window = WindowOf(lists, tile);
  pass.loss.Load(lists, window);
  for (int k = 0; k < 3; ++k) LoadPlane<V>(lists, window, loss.rendered + k * plane, pass.behind[k]);
  TraverseSplats<V>(lists, tile, pass);
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
