// SPDX-License-Identifier: Apache-2.0
// Change of a view's loss when its pixels change. loss_passes.h uses it to predict the effect of removing or
// recolouring a splat. (Pixel penalty, SSIM, G, s, c: kernels/image/photometric_formula.h.)
//
// The penalty of each pixel is exact. 1 - SSIM is approximated by its quadratic with the Hessian diag(G s) + G diag(c)
// G, where G is the blur with the SSIM window. The second part couples pixels. Let delta be the change of the image
// when one splat changes. To avoid a blur per splat, G delta is approximated by a constant times delta. The constant is
// the fraction of the energy (sum of squares) that remains when a Gaussian with covariance C is blurred with variance
// v:
//   sqrt(det C / det(C + v I)) = 1 / sqrt(det(I + v C^-1)).
#pragma once

#include <algorithm>
#include <cmath>

#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/tiles/tile_pixels.h"
#include "kernels/image/pixel_penalty.h"
#include "kernels/math/lanes.h"

namespace vesta::splat {

// The linearised loss of one view (PhotometricLinearization in kernels/image/photometric_loss.h). Images have 3 planes.
template <class S>
struct LinearizedLoss {
  const S *rendered, *truth;
  const S* gradient;   // derivative of the loss with respect to the pixel
  const S* diagonal;   // l1 * curvature of the penalty + ssim * G s
  const S* curvature;  // c
  PenaltyCoefficients<S> penalty;
  S l1, ssim;                 // weights
  S window_variance;          // of the SSIM window, pixels squared
  const S* counts = nullptr;  // one plane: 1, or 0 for masked pixels; null: all 1
};

inline namespace VESTA_ISA {

// Fraction of a splat's energy that remains after a blur of this variance. C^-1 is the conic, 2 ln 2 times F^T F, where
// F is the map from d to (p, q) (types.h).
template <class S>
VESTA_HD inline S EnergyAfterBlur(const Splat<S>& splat, S variance) {
  const S scale = static_cast<S>(kTwoLn2) * variance, r2 = splat.r * splat.r, s2 = splat.s * splat.s;
  const S trace = r2 * (S(1) + splat.beta * splat.beta) + s2;
  return S(1) / std::sqrt(S(1) + scale * (trace + scale * r2 * s2));
}

// The loss at the pixels of one tile. offset: first pixel of a SIMD vector, within the tile.
template <class V, class S>
struct LossOfChange {
  using L = Lanes<V>;
  LinearizedLoss<S> loss;
  alignas(64) S error[3][kTilePixels], gradient[3][kTilePixels], diagonal[3][kTilePixels], curvature[3][kTilePixels];
  alignas(64) S counts[kTilePixels];

  // Copies the tile from the images of `loss`.
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
  // The argument window_factor of AddCurvature and AddRise.
  V WindowFactor(const Splat<S>& splat) const { return V(loss.ssim * EnergyAfterBlur(splat, loss.window_variance)); }
  // second += the second derivative of the loss with respect to t when the pixels of channel k change by t * share.
  void AddCurvature(int k, int offset, const V& share, const V& window_factor, V& second) const {
    const V of_pixel = Fma(window_factor, L::Load(curvature[k] + offset), L::Load(diagonal[k] + offset));
    const V own = share * L::Load(counts + offset);
    second = Fma(own * own, of_pixel, second);
  }
  // rise += the rise of the loss if the pixels of channel k change by `change`.
  void AddRise(int k, int offset, const V& change, const V& window_factor, V& rise) const {
    const V delta = change * L::Load(counts + offset);
    const V e = L::Load(error[k] + offset), l1(loss.l1);
    const PixelPenalty<V> before(e, loss.penalty), after(e + delta, loss.penalty);
    // First and second derivative of the SSIM part of the loss: total derivative minus derivative of the penalty.
    const V ssim_slope = Fnma(l1, before.derivative, L::Load(gradient[k] + offset));
    const V pointwise = Fnma(l1, before.Curvature(loss.penalty), L::Load(diagonal[k] + offset));
    const V ssim_curvature = Fma(window_factor, L::Load(curvature[k] + offset), pointwise);
    rise = Fma(l1, after.value - before.value, Fma(delta, Fma(V(S(0.5)) * ssim_curvature, delta, ssim_slope), rise));
  }
};

}  // namespace VESTA_ISA

// Recolouring: the loss of a view if one splat has the colour c' instead of c. Pixels change by exactly delta = w (c' -
// c) with w = alpha T.
inline constexpr int kRecolors = 3;  // colours tried per splat: one for each lower SH degree

// Colours to try for one splat.
template <class S>
struct Recolors {
  S color[kRecolors][3];  // after the clamp at 0
};
// Results for one splat, summed over pixels and channels.
template <class S>
struct RecolorRises {
  S rise[kRecolors];  // rise of the loss if the splat has this colour
};

// Second derivative of the loss with respect to the colour of one splat, per channel.
template <class S>
struct ColorCurvature {
  S channel[3];
};

}  // namespace vesta::splat
