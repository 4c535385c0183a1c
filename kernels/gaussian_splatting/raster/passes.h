// SPDX-License-Identifier: Apache-2.0
// The raster passes over one tile on the CPU: image, tangent, adjoint, Gram sums, and visit counts. Formulas and
// symbols: pixel_steps.h, splat_sums.h.
//
// Adjoint and Gram passes need the colour behind a splat: the sum of the weighted colours of all later splats and the
// background. It is the final colour of the pixel minus the weighted colours up to and including the splat. These
// passes therefore also visit the splats front to back, and they store no data per pixel and splat.
#pragma once

#include "kernels/gaussian_splatting/formulas/pixel_steps.h"
#include "kernels/gaussian_splatting/raster/splat_sums.h"
#include "kernels/gaussian_splatting/raster/traverse_rows.h"
#include "kernels/gaussian_splatting/raster/traverse_splats.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

template <class V, class S>
struct CountPass {
  using L = Lanes<V>;
  VisitCounts counts;

  struct State {};
  void Prepare(int, const Splat<S>&, std::uint32_t) { ++counts.pairs; }
  void PrepareRow(int, const V&) {}
  State Load(int) const { return {}; }
  void Store(const State&, int) {}
  void Pixels(State&, std::uint32_t, const V&, const Blend<V>& blend) {
    const std::uint32_t bits = L::Bits(blend.alpha > V(0));
    ++counts.vectors;
    counts.useful += bits != 0 ? 1 : 0;
    counts.pixels += std::popcount(bits);
  }
};

template <class V, class S>
struct ForwardPass {
  using L = Lanes<V>;
  alignas(64) S color[3][kTilePixels];
  alignas(64) S transmittance[kTilePixels];  // behind the last splat that contributes to the pixel
  struct {
    S color[3], pad;
  } of[RowBatch<V, S>::kPlaces];

  struct State {
    V color[3], transmittance;
  };
  ForwardPass() {
    for (S* plane : color) SetZero<V>(plane);
    for (S& t : transmittance) t = S(1);
  }
  void Prepare(int place, const Splat<S>& splat, std::uint32_t) {
    for (int k = 0; k < 3; ++k) of[place].color[k] = splat.color[k];
  }
  void PrepareRow(int, const V&) {}
  State Load(int offset) const {
    return {{L::Load(color[0] + offset), L::Load(color[1] + offset), L::Load(color[2] + offset)},
            L::Load(transmittance + offset)};
  }
  void Store(const State& state, int offset) {
    for (int k = 0; k < 3; ++k) L::Store(color[k] + offset, state.color[k]);
    L::Store(transmittance + offset, state.transmittance);
  }
  void Pixels(State& state, std::uint32_t place, const V&, const Blend<V>& blend) {
    for (int k = 0; k < 3; ++k) state.color[k] = Fma(blend.weight, V(of[place].color[k]), state.color[k]);
    state.transmittance = Select(blend.open, blend.transmittance, state.transmittance);
  }
  V WithBackground(const V& background, int channel, int offset) const {
    return Fma(L::Load(transmittance + offset), background, L::Load(color[channel] + offset));
  }
};

template <class V, class S>
struct TangentPass {
  using L = Lanes<V>;
  static constexpr int kPlaces = RowBatch<V, S>::kPlaces;
  const SplatTangent<S>* tangents;
  alignas(64) S d_color[3][kTilePixels];
  alignas(64) S minus_dT[kTilePixels];  // minus the derivative of the transmittance
  // For each splat of the batch: the shape components of its tangent, and for the current row the coefficients of psi =
  // constant - p (linear + rho p).
  alignas(64) S shape[kSplatShape][kPlaces], linear[kPlaces], constant[kPlaces];
  struct {
    S color[3], d_color[3], pad[2];
  } of[kPlaces];

  struct State {
    V d_color[3], minus_dT;
  };
  explicit TangentPass(const SplatTangent<S>* splat_tangents) : tangents(splat_tangents) {
    for (S* plane : d_color) SetZero<V>(plane);
    SetZero<V>(minus_dT);
  }
  void Prepare(int place, const Splat<S>& splat, std::uint32_t rank) {
    const S* w = tangents[rank].w;
    for (int k = 0; k < kSplatShape; ++k) shape[k][place] = w[k];
    for (int k = 0; k < 3; ++k) of[place].color[k] = splat.color[k], of[place].d_color[k] = w[kColor + k];
  }
  void PrepareRow(int first, const V& q) {
    const auto member = [&](int k) { return L::Load(shape[k] + first); };
    L::Store(linear + first, PsiLinear(member(kXi), member(kKappa), q));
    L::Store(constant + first, PsiConstant(member(kZeta), member(kSigma), member(kLambda), q));
  }
  State Load(int offset) const {
    return {{L::Load(d_color[0] + offset), L::Load(d_color[1] + offset), L::Load(d_color[2] + offset)},
            L::Load(minus_dT + offset)};
  }
  void Store(const State& state, int offset) {
    for (int k = 0; k < 3; ++k) L::Store(d_color[k] + offset, state.d_color[k]);
    L::Store(minus_dT + offset, state.minus_dT);
  }
  void Pixels(State& state, std::uint32_t place, const V& p, const Blend<V>& blend) {
    const V psi = Psi(V(linear[place]), V(constant[place]), V(shape[kRho][place]), p);
    const V d_weight = TangentWeight(blend, psi, state.minus_dT);
    for (int k = 0; k < 3; ++k) {
      state.d_color[k] =
          TangentColor(blend, d_weight, V(of[place].color[k]), V(of[place].d_color[k]), state.d_color[k]);
    }
  }
  V WithBackground(const V& background, int channel, int offset) const {
    return Fnma(L::Load(minus_dT + offset), background, L::Load(d_color[channel] + offset));
  }
};

// Runs two passes of TraverseRows together.
template <class First, class Second>
struct BothPasses {
  First first;
  Second second;

  struct State {
    typename First::State first;
    typename Second::State second;
  };
  template <class S>
  void Prepare(int place, const Splat<S>& splat, std::uint32_t rank) {
    first.Prepare(place, splat, rank);
    second.Prepare(place, splat, rank);
  }
  template <class V>
  void PrepareRow(int place, const V& q) {
    first.PrepareRow(place, q);
    second.PrepareRow(place, q);
  }
  State Load(int offset) const { return {first.Load(offset), second.Load(offset)}; }
  void Store(const State& state, int offset) {
    first.Store(state.first, offset);
    second.Store(state.second, offset);
  }
  template <class V>
  void Pixels(State& state, std::uint32_t place, const V& p, const Blend<V>& blend) {
    first.Pixels(state.first, place, p, blend);
    second.Pixels(state.second, place, p, blend);
  }
};

template <class V, class S>
struct AdjointPass {
  using L = Lanes<V>;
  SplatTangent<S>* sums;              // [pairs] of all tiles, indexed like TileLists::ranks
  alignas(64) S u[3][kTilePixels];    // cotangent of the image
  alignas(64) S behind[kTilePixels];  // u . colour behind the last visited splat

  struct State {
    V c[3];
    CotangentSums<V> total;
  };
  State Begin(const Splat<S>& splat) const { return {{V(splat.color[0]), V(splat.color[1]), V(splat.color[2])}, {}}; }
  void Pixels(State& state, S q, int offset, const V& p, const Blend<V>& blend) {
    const V u_here[3] = {L::Load(u[0] + offset), L::Load(u[1] + offset), L::Load(u[2] + offset)};
    V rest = L::Load(behind + offset);
    const V g = ByLogAlpha(blend, AlphaOdds(blend.alpha), ContributionOf(blend, state.c, u_here), rest);
    L::Store(behind + offset, rest);
    for (int k = 0; k < 3; ++k) state.total.AddColor(k, blend.weight, u_here[k]);
    state.total.AddShape(g, p, V(q));
    state.total.AddPull(g, p, V(q));
  }
  void End(State& state, std::int64_t pair) { L::template SumEach<kSplatSums>(state.total.sum, sums[pair].w); }
  void Skip(std::int64_t pair) { sums[pair] = {}; }
};

template <class V, class S>
struct GramPass {
  using L = Lanes<V>;
  SplatGram<S>* sums;
  alignas(64) S omega[3][kTilePixels];   // curvature of the loss with respect to each colour
  alignas(64) S behind[3][kTilePixels];  // colour behind the last visited splat

  struct State {
    V c[3];
    GramSums<V> total;
  };
  State Begin(const Splat<S>& splat) const { return {{V(splat.color[0]), V(splat.color[1]), V(splat.color[2])}, {}}; }
  void Pixels(State& state, S q, int offset, const V& p, const Blend<V>& blend) {
    const V odds = AlphaOdds(blend.alpha);
    state.total.Add(blend.weight, p, q, [&](int k) {
      V rest = L::Load(behind[k] + offset);
      const V d = ByLogAlpha(blend, odds, blend.weight * state.c[k], rest);
      L::Store(behind[k] + offset, rest);
      return GramColor<V>{L::Load(omega[k] + offset), d};
    });
  }
  void End(State& state, std::int64_t pair) {
    S* out = sums[pair].m;
    L::template SumEach<kMoments4>(state.total.shape, out);
    L::template SumEach<3 * kMoments2>(state.total.cross[0], out + kMoments4);
    L::template SumEach<3>(state.total.color, out + kMoments4 + 3 * kMoments2);
  }
  void Skip(std::int64_t pair) { sums[pair] = {}; }
};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
