// SPDX-License-Identifier: Apache-2.0
// The raster pass over one tile that tells what the loss of a view would be without a splat, of each splat by itself.
//
// A pixel is affine in the alpha of each splat. So without the splat its colour changes by exactly
//   delta = -alpha d colour / d alpha = S alpha / (1 - alpha) - w c                (pixel_steps.h: w = alpha T)
// as long as no pixel closes later for it (the transmittance stop). What that does to the loss: loss_of_change.h.
#pragma once

#include "kernels/gaussian_splatting/raster/loss_of_change.h"
#include "kernels/gaussian_splatting/raster/traverse_splats.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

template <class V, class S>
struct RemovalPass {
  using L = Lanes<V>;
  S* rises;  // summed over pixels and channels
  LossOfChange<V, S> loss;
  alignas(64) S behind[3][kTilePixels];  // S of pixel_steps.h

  struct State {
    V c[3], left_by_window;
    V sum;
  };
  State Begin(const Splat<S>& splat) const {
    return {{V(splat.color[0]), V(splat.color[1]), V(splat.color[2])}, loss.LeftByWindow(splat), V(0)};
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
    state.sum = state.sum + Select(blend.alpha > V(0), rise, V(0));
  }
  void End(State& state, std::int64_t pair) { L::template SumEach<1>(&state.sum, rises + pair); }
  void Skip(std::int64_t pair) { rises[pair] = 0; }
};

template <class V, class S>
void RemovalTile(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss, S* pair_rises) {
  RemovalPass<V, S> pass;
  pass.rises = pair_rises;
  pass.loss.loss = loss;
  const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
  const TileWindow window = WindowOf(lists, tile);
  pass.loss.Load(lists, window);
  for (int k = 0; k < 3; ++k) LoadPlane<V>(lists, window, loss.rendered + k * plane, pass.behind[k]);
  TraverseSplats<V>(lists, tile, pass);
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
