// SPDX-License-Identifier: Apache-2.0
// The photometric loss of a view of which not every pixel counts.
//
// A pixel that is left out shows the photograph: with m the mask (1: counts) it is the loss of
//   m o rendered + (1 - m) o truth
// So it has no error of its own, windows of SSIM that reach over the border of the mask see what there is to see, and
// all is exact: the gradient by the rendered image is m o the loss's, and its curvature M W M, M = diag(m), which stays
// positive semidefinite. Sums are over all pixels; those left out add what windows about them see of their neighbours.
// Without a mask nothing is done, and no bit differs.
#pragma once

#include "kernels/core/check.h"
#include "kernels/core/for_each.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "problems/gaussian_splatting/scene/mask_pixels.h"

namespace vesta::gs {

inline constexpr Index kMaskGrain = 1 << 15;

// Throws Error where the truth is not of its view's size, or missing.
template <class B>
void CheckTruth(const TargetView<B>& view) {
  VESTA_CHECK(view.truth.size() == view.shape().NumValues(), "a truth image of {} values for a view of {} x {}",
              view.truth.size(), view.camera.width, view.camera.height);
}

// mask: a byte a pixel, in the memory of B, or empty. image: its three planes.
template <class B, class Mask>
void ShowLeftOut(const Mask& mask, typename B::ConstVectorView truth, typename B::VectorView image) {
  if (mask.size() == 0) return;
  ForEach<typename B::Space>(
      mask.size(), kMaskGrain,
      ShowWhereLeftOut<typename B::Scalar>{mask.data(), truth.data(), image.data(), mask.size()});
}
template <class B, class Mask>
void ClearLeftOut(const Mask& mask, typename B::VectorView image) {
  if (mask.size() == 0) return;
  ForEach<typename B::Space>(mask.size(), kMaskGrain,
                             ClearWhereLeftOut<typename B::Scalar>{mask.data(), image.data(), mask.size()});
}

// The loss's own functions for a view. rendered: what is left out is changed in it to what the photograph shows.
template <class B>
PhotometricValue EvaluateLoss(typename SplatBackend<B>::Loss& loss, const TargetView<B>& target,
                              typename B::VectorView rendered) {
  ShowLeftOut<B>(target.mask, typename B::ConstVectorView(target.truth), rendered);
  return loss.Evaluate(rendered, target.truth, target.shape());
}
template <class B>
void LossGradient(typename SplatBackend<B>::Loss& loss, const TargetView<B>& target, typename B::VectorView rendered,
                  typename B::VectorView gradient) {
  ShowLeftOut<B>(target.mask, typename B::ConstVectorView(target.truth), rendered);
  loss.Gradient(rendered, target.truth, target.shape(), gradient);
  ClearLeftOut<B>(target.mask, gradient);
}
// linearization: W without the mask, which products with it are to be given between two ClearLeftOut; its diagonal is
// that of M W M.
template <class B>
void LinearizeLoss(typename SplatBackend<B>::Loss& loss, const TargetView<B>& target, typename B::VectorView rendered,
                   typename B::VectorView gradient, typename SplatBackend<B>::Loss::Linearization& linearization) {
  ShowLeftOut<B>(target.mask, typename B::ConstVectorView(target.truth), rendered);
  loss.Linearize(rendered, target.truth, target.shape(), gradient, linearization);
  ClearLeftOut<B>(target.mask, gradient);
  ClearLeftOut<B>(target.mask, typename B::VectorView(linearization.diagonal));
}

}  // namespace vesta::gs
