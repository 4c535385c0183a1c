// SPDX-License-Identifier: Apache-2.0
// The photometric loss of a view in which a mask excludes some pixels.
//
// An excluded pixel shows the photograph in the loss. With the mask m (1: pixel included), the loss is evaluated at
//   m o rendered + (1 - m) o truth.
// So an excluded pixel has no error of its own, and SSIM windows that cross the border of the mask see complete images.
// Derivatives are exact: the gradient with respect to the rendered image is m o the gradient of the loss. The curvature
// is M W M with M = diag(m), which stays positive semidefinite. Sums run over all pixels; SSIM windows around excluded
// pixels still contribute the errors of included neighbours. Without a mask the result is bit-identical to the plain
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

// Copies the excluded pixels from the truth. mask: one byte per pixel, in the memory of B, or empty. image: three
// planes.
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

// The functions of the loss for one view. They overwrite the excluded pixels of `rendered` with the photograph.
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
// linearization holds W without the mask: callers apply ClearLeftOut before and after each product with it. Its
// diagonal belongs to M W M.
template <class B>
void LinearizeLoss(typename SplatBackend<B>::Loss& loss, const TargetView<B>& target, typename B::VectorView rendered,
                   typename B::VectorView gradient, typename SplatBackend<B>::Loss::Linearization& linearization) {
  ShowLeftOut<B>(target.mask, typename B::ConstVectorView(target.truth), rendered);
  loss.Linearize(rendered, target.truth, target.shape(), gradient, linearization);
  ClearLeftOut<B>(target.mask, gradient);
  ClearLeftOut<B>(target.mask, typename B::VectorView(linearization.diagonal));
}

}  // namespace vesta::gs
