// SPDX-License-Identifier: Apache-2.0
// Raster passes over one tile. They predict how the loss of a view changes if one splat is removed or recoloured and
// all others are unchanged.
//
// The colour of a pixel is an affine function of the alpha of each splat. If a splat with colour c is removed, the
// colour of the pixel therefore changes by exactly
//   delta = -alpha d colour / d alpha = S alpha / (1 - alpha) - w c                (pixel_steps.h: w = alpha T)
// unless the pixel would then be closed later. loss_of_change.h computes the resulting change of the loss.
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
    V c[3], window_factor;
    V sum;
  };
  State Begin(const Splat<S>& splat) const {
    return {{V(splat.color[0]), V(splat.color[1]), V(splat.color[2])}, loss.WindowFactor(splat), V(0)};
  }
  void Pixels(State& state, S, int offset, const V&, const Blend<V>& blend) {
    const V odds = AlphaOdds(blend.alpha);
    V rise(0);
    for (int k = 0; k < 3; ++k) {
      const V share = blend.weight * state.c[k];
      const V rest = L::Load(behind[k] + offset) - share;
      L::Store(behind[k] + offset, rest);
      loss.AddRise(k, offset, Fma(rest, odds, -share), state.window_factor, rise);
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

// Rise of the loss for other colours of a splat.
template <class V, class S>
struct RecolorPass {
  using L = Lanes<V>;
  const TileLists<S>& lists;
  const Recolors<S>* recolors;  // by rank
  RecolorRises<S>* sums;
  LossOfChange<V, S> loss;

  struct State {
    V change[kRecolors][3], window_factor;
    V sum[kRecolors];
  };
  State Begin(const Splat<S>& splat) const {
    State state{{}, loss.WindowFactor(splat), {}};
    const Recolors<S>& to = recolors[&splat - lists.splats];
    for (int d = 0; d < kRecolors; ++d) {
      for (int k = 0; k < 3; ++k) state.change[d][k] = V(to.color[d][k] - splat.color[k]);
      state.sum[d] = V(0);
    }
    return state;
  }
  void Pixels(State& state, S, int offset, const V&, const Blend<V>& blend) {
    for (int d = 0; d < kRecolors; ++d) {
      V rise(0);
      for (int k = 0; k < 3; ++k) {
        loss.AddRise(k, offset, blend.weight * state.change[d][k], state.window_factor, rise);
      }
      state.sum[d] = state.sum[d] + Select(blend.alpha > V(0), rise, V(0));
    }
  }
  void End(State& state, std::int64_t pair) { L::template SumEach<kRecolors>(state.sum, sums[pair].rise); }
  void Skip(std::int64_t pair) { sums[pair] = {}; }
};

template <class V, class S>
struct ColorCurvaturePass {
  using L = Lanes<V>;
  ColorCurvature<S>* sums;
  LossOfChange<V, S> loss;

  struct State {
    V window_factor;
    V sum[3];
  };
  State Begin(const Splat<S>& splat) const { return {loss.WindowFactor(splat), {V(0), V(0), V(0)}}; }
  void Pixels(State& state, S, int offset, const V&, const Blend<V>& blend) {
    for (int k = 0; k < 3; ++k) {
      loss.AddCurvature(k, offset, blend.weight, state.window_factor, state.sum[k]);
    }
  }
  void End(State& state, std::int64_t pair) { L::template SumEach<3>(state.sum, sums[pair].channel); }
  void Skip(std::int64_t pair) { sums[pair] = {}; }
};

template <class V, class S>
void ColorCurvatureTile(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss,
                        ColorCurvature<S>* pair_sums) {
  ColorCurvaturePass<V, S> pass;
  pass.sums = pair_sums;
  pass.loss.loss = loss;
  pass.loss.Load(lists, WindowOf(lists, tile));
  TraverseSplats<V>(lists, tile, pass);
}

template <class V, class S>
void RecolorTile(const TileLists<S>& lists, int tile, const LinearizedLoss<S>& loss, const Recolors<S>* recolors,
                 RecolorRises<S>* pair_sums) {
  RecolorPass<V, S> pass{lists, recolors, pair_sums, {}};
  pass.loss.loss = loss;
  pass.loss.Load(lists, WindowOf(lists, tile));
  TraverseSplats<V>(lists, tile, pass);
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
