// What the loss of a view would be without a splat, of each splat by itself.
//
// A pixel is affine in the alpha of each splat. So without the splat its colour changes by exactly
//   delta = -alpha d colour / d alpha = S alpha / (1 - alpha) - w c                (pixel_steps.h: w = alpha T)
// as long as no pixel closes later for it (the transmittance stop). The loss of a pixel by itself is then known
// exactly. SSIM is that quadratic of kernels/image/photometric_loss.h whose Hessian is diag(G s) + G diag(c) G: its
// second part couples pixels. G delta is delta times what the window leaves of the splat: of the energy of a Gaussian
// of covariance C under a window of variance v there remains
//   sqrt(det C / det(C + v I)) = 1 / sqrt(det(I + v C^-1)).
#pragma once

#include "kernels/gaussian_splatting/types.h"
#include "kernels/image/pixel_penalty.h"

namespace vesta::splat {

// The loss of one view where it is linearised: images of 3 planes, as kernels/image/photometric_linearization.h has
// them for the quadratic of SSIM.
template <class S>
struct RemovalLoss {
  const S *rendered, *truth;
  const S* gradient;   // of the loss by the pixel
  const S* diagonal;   // l1 * curvature of the penalty + ssim * G s
  const S* curvature;  // c
  PenaltyCoefficients<S> penalty;
  S l1, ssim;         // weights
  S window_variance;  // of the window of SSIM, pixels squared
};

// Of one splat, summed over pixels and channels.
template <class S>
struct Removal {
  S rise;    // of the loss when the splat goes; negative where that is better without it
  S weight;  // of its shares of the pixels, alpha T: not by channels
};
inline constexpr int kRemovalSums = 2;

}  // namespace vesta::splat
