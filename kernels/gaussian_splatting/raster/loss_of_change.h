// SPDX-License-Identifier: Apache-2.0
// By how much the loss of a view changes when its pixels do: for passes that predict the effect of removing or
// recolouring a splat.
//
// The loss of a pixel by itself is known exactly. SSIM is that quadratic of kernels/image/photometric_loss.h whose
// Hessian is diag(G s) + G diag(c) G: its second part couples pixels. Where the change delta of all pixels is that of a
// splat, G delta is delta times what the window leaves of the splat: of the energy of a Gaussian of covariance C under
// a window of variance v there remains
//   sqrt(det C / det(C + v I)) = 1 / sqrt(det(I + v C^-1)).
#pragma once

#include <algorithm>
#include <cmath>

#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/tiles/tile_pixels.h"
#include "kernels/image/pixel_penalty.h"
#include "kernels/math/lanes.h"

namespace vesta::splat {

// The loss of one view where it is linearised: images of 3 planes, as kernels/image/photometric_loss.h has
// them for the quadratic of SSIM.
template <class S>
struct LinearizedLoss {
  const S *rendered, *truth;
  const S* gradient;   // of the loss by the pixel
  const S* diagonal;   // l1 * curvature of the penalty + ssim * G s
  const S* curvature;  // c
  PenaltyCoefficients<S> penalty;
  S l1, ssim;                 // weights
  S window_variance;          // of the window of SSIM, pixels squared
  const S* counts = nullptr;  // one plane: 1, or 0 for a pixel of which no change is any to the loss; null: all 1
};

inline namespace VESTA_ISA {

// The share of a splat's energy that a window leaves, by its conic: 2 ln 2 times the square of what maps d to (p, q).
template <class S>
VESTA_HD inline S EnergyUnderWindow(const Splat<S>& splat, S variance) {
  const S scale = static_cast<S>(kTwoLn2) * variance, r2 = splat.r * splat.r, s2 = splat.s * splat.s;
  const S trace = r2 * (S(1) + splat.beta * splat.beta) + s2;
  return S(1) / std::sqrt(S(1) + scale * (trace + scale * r2 * s2));
}

// Over the pixels of one tile.
template <class V, class S>
struct LossOfChange {
  using L = Lanes<V>;
  LinearizedLoss<S> loss;
  alignas(64) S error[3][kTilePixels], gradient[3][kTilePixels], diagonal[3][kTilePixels], curvature[3][kTilePixels];
  alignas(64) S counts[kTilePixels];

  void Load(const TileLists<S>& lists, const TileWindow& window) {
    const std::int64_t plane = static_cast<std::int64_t>(lists.width) * lists.height;
    alignas(64) S truth[kTilePixels];
    for (int k = 0; k < 3; ++k) {
      LoadPlane<V>(lists, window, loss.rendered + k * plane, error[k]);
      LoadPlane<V>(lists, window, loss.truth + k * plane, truth);
      for (int i = 0; i < kTilePixels; ++i) error[k][i] -= truth[i];
      LoadPlane<V>(lists, window, loss.gradient + k * plane, gradient[k]);
      LoadPlane<V>(lists, window, loss.diagonal + k * plane, diagonal[k]);
      LoadPlane<V>(lists, window, loss.curvature + k * plane, curvature[k]);
    }
    if (loss.counts != nullptr) {
      LoadPlane<V>(lists, window, loss.counts, counts);
    } else {
      std::fill(counts, counts + kTilePixels, S(1));
    }
  }
  // To be given to AddRise for a splat's pixels.
  V LeftByWindow(const Splat<S>& splat) const { return V(loss.ssim * EnergyUnderWindow(splat, loss.window_variance)); }
  // bend += the second derivative of the loss by t where pixels of channel k change by t share.
  void AddCurvature(int k, int offset, const V& share, const V& left_by_window, V& bend) const {
    const V of_pixel = Fma(left_by_window, L::Load(curvature[k] + offset), L::Load(diagonal[k] + offset));
    const V own = share * L::Load(counts + offset);
    bend = Fma(own * own, of_pixel, bend);
  }
  // rise += that of the loss when pixels of channel k change by `change`.
  void AddRise(int k, int offset, const V& change, const V& left_by_window, V& rise) const {
    const V delta = change * L::Load(counts + offset);
    const V e = L::Load(error[k] + offset), l1(loss.l1);
    const PixelPenalty<V> before(e, loss.penalty), after(e + delta, loss.penalty);
    const V slope = Fnma(l1, before.derivative, L::Load(gradient[k] + offset));  // of SSIM alone, as is the curvature
    const V pointwise = Fnma(l1, before.Curvature(loss.penalty), L::Load(diagonal[k] + offset));
    const V bend = Fma(left_by_window, L::Load(curvature[k] + offset), pointwise);
    rise = Fma(l1, after.value - before.value, Fma(delta, Fma(V(S(0.5)) * bend, delta, slope), rise));
  }
};

}  // namespace VESTA_ISA

// Recolouring: the loss of a view were a splat of another colour c', of each splat by itself. Its pixels would change
// by exactly delta = w (c' - c), w = alpha T.
inline constexpr int kRecolors = 3;  // that are asked for at a time: of the lower degrees of the harmonics

// Of one splat.
template <class S>
struct Recolors {
  S color[kRecolors][3];  // after the clamp at 0
};
// Of one splat, summed over pixels and channels.
template <class S>
struct RecolorRises {
  S rise[kRecolors];  // of the loss when the splat has that colour
};

// Of one splat, by channel: the second derivative of the loss by its colour.
template <class S>
struct ColorCurvature {
  S channel[3];
};

}  // namespace vesta::splat
