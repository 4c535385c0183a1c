// The loss of one view as the passes of loss_of_change.h are given it.
#pragma once

#include "kernels/image/pixel_penalty.h"

namespace vesta::splat {

// The loss of one view where it is linearised: images of 3 planes, as kernels/image/photometric_linearization.h has
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

}  // namespace vesta::splat
