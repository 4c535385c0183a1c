// SPDX-License-Identifier: Apache-2.0
// The photometric loss of a view in which a mask excludes some pixels.
//
// Before the loss is evaluated, the excluded pixels of the rendered image are replaced by pixels of the photograph (the
// truth). With the mask m (1: pixel included), the loss is evaluated at
//   m o rendered + (1 - m) o truth.
// So an excluded pixel has no error of its own, and SSIM windows that cross the border of the mask see complete images.
// The sums of the loss run over all pixels, because the SSIM window around an excluded pixel may contain included
// pixels with errors.
//
// Derivatives are exact: the gradient with respect to the rendered image is m o the gradient of the loss. The curvature
// is M W M with M = diag(m), which stays positive semidefinite. Without a mask the result is bit-identical to the plain
// loss.
#pragma once

#include "kernels/core/check.h"
#include "kernels/core/for_each.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "problems/gaussian_splatting/scene/mask_pixels.h"

namespace vesta::gs {

inline constexpr Index kMaskGrain = 1 << 15;

// Throws Error if the truth is missing or does not match the size of its view.
template <class B>
void CheckTruth(const TargetView<B>& view) {
  VESTA_CHECK(view.truth.size() == view.shape().NumValues(),
              "a truth image of {} values does not match a view of {} x {}", view.truth.size(), view.camera.width,
              view.camera.height);
}

// FillMasked copies the excluded pixels of the truth to the image. ClearMasked sets them to zero. mask: one byte per
// pixel, in the memory of B, or empty. image: three planes.
template <class B, class Mask>
void FillMasked(const Mask& mask, typename B::ConstVectorView truth, typename B::VectorView image) {
  if (mask.size() == 0) return;
  ForEach<typename B::Space>(
      mask.size(), kMaskGrain,
      FillMaskedPixels<typename B::Scalar>{mask.data(), truth.data(), image.data(), mask.size()});
}
template <class B, class Mask>
void ClearMasked(const Mask& mask, typename B::VectorView image) {
  if (mask.size() == 0) return;
  ForEach<typename B::Space>(mask.size(), kMaskGrain,
                             ClearMaskedPixels<typename B::Scalar>{mask.data(), image.data(), mask.size()});
}

// The functions of the loss for one view. They overwrite the excluded pixels of `rendered` with the photograph.
template <class B>
PhotometricValue EvaluateLoss(typename SplatBackend<B>::Loss& loss, const TargetView<B>& target,
                              typename B::VectorView rendered) {
  FillMasked<B>(target.mask, typename B::ConstVectorView(target.truth), rendered);
  return loss.Evaluate(rendered, target.truth, target.shape());
}
template <class B>
void LossGradient(typename SplatBackend<B>::Loss& loss, const TargetView<B>& target, typename B::VectorView rendered,
                  typename B::VectorView gradient) {
  FillMasked<B>(target.mask, typename B::ConstVectorView(target.truth), rendered);
  loss.Gradient(rendered, target.truth, target.shape(), gradient);
  ClearMasked<B>(target.mask, gradient);
}
// `linearization` represents W, not M W M: callers apply ClearMasked before and after each product with it. Only its
// diagonal includes the mask: it is the diagonal of M W M.
template <class B>
void LinearizeLoss(typename SplatBackend<B>::Loss& loss, const TargetView<B>& target, typename B::VectorView rendered,
                   typename B::VectorView gradient, typename SplatBackend<B>::Loss::Linearization& linearization) {
  FillMasked<B>(target.mask, typename B::ConstVectorView(target.truth), rendered);
  loss.Linearize(rendered, target.truth, target.shape(), gradient, linearization);
  ClearMasked<B>(target.mask, gradient);
  ClearMasked<B>(target.mask, typename B::VectorView(linearization.diagonal));
}

}  // namespace vesta::gs
