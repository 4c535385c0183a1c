// SPDX-License-Identifier: Apache-2.0
// The curvature operator W of the photometric loss at one rendered image, and the interface that makes and applies it.
#pragma once

#include <memory>

#include "kernels/core/buffer.h"
#include "kernels/image/loss_options.h"
#include "kernels/image/row_bands.h"

namespace vesta {

// Owned by the caller, one for each view that is linearised at the same time. Images of 3 * height * width values: the
// diagonal, and by the choice of SsimLinearization
//   kQuadratic   one more: W v = diagonal o v + ssim * G (curvature o (G v));
//   kRootCenter  none: W v = diagonal o v.
template <class S>
struct PhotometricLinearization {
  ImageShape shape;
  // The weight of Gram matrices in place of W: never negative. W's exact diagonal with the root; with the quadratic
  // l1 * penalty'' + 2 ssim G(l / D2), the pointwise part (the part left out is negative for most windows).
  HostBuffer<S> diagonal;
  HostBuffer<S> curvature;  // 2 (1/D1 - l/D2)
};

// One choice of SsimLinearization. Images are of the shape of `bands`; sizes are checked by the caller.
template <class S>
class SsimStrategy {
 public:
  using Linearization = PhotometricLinearization<S>;
  virtual ~SsimStrategy() = default;

  // Computes the sums of the loss, its gradient, and unless null its linearization.
  virtual void Gradient(RowBands<S>& bands, const LossTerms<S>& loss, S* gradient, Linearization* linearization) = 0;
  // out = W v. loss: its weights alone.
  virtual void ApplyW(RowBands<S>& bands, const LossTerms<S>& loss, const Linearization& linearization, const S* v,
                      S* out) = 0;
};

template <class S>
std::unique_ptr<SsimStrategy<S>> MakeQuadraticSsim();
template <class S>
std::unique_ptr<SsimStrategy<S>> MakeRootCenterSsim();

}  // namespace vesta
