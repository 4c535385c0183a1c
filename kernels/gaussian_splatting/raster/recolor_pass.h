// SPDX-License-Identifier: Apache-2.0
// The raster passes of recolor.h over one tile.
#pragma once

#include "kernels/gaussian_splatting/raster/loss_of_change.h"
#include "kernels/gaussian_splatting/raster/recolor.h"
#include "kernels/gaussian_splatting/raster/traverse_splats.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

template <class V, class S>
struct RecolorPass {
  using L = Lanes<V>;
  const TileLists<S>& lists;
  const Recolors<S>* recolors;  // by rank
  RecolorRises<S>* sums;
  LossOfChange<V, S> loss;

  struct State {
    V change[kRecolors][3], left_by_window;
    V sum[kRecolors];
  };
  State Begin(const Splat<S>& splat) const {
    State state{{}, loss.LeftByWindow(splat), {}};
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
        loss.AddRise(k, offset, blend.weight * state.change[d][k], state.left_by_window, rise);
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
    V left_by_window;
    V sum[3];
  };
  State Begin(const Splat<S>& splat) const { return {loss.LeftByWindow(splat), {V(0), V(0), V(0)}}; }
  void Pixels(State& state, S, int offset, const V&, const Blend<V>& blend) {
    for (int k = 0; k < 3; ++k) {
      loss.AddCurvature(k, offset, blend.weight, state.left_by_window, state.sum[k]);
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
