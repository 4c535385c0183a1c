// SPDX-License-Identifier: Apache-2.0
// The photometric loss of a view with a mask that excludes pixels.
//
// Pixels of the photograph, the truth, replace the excluded pixels of the rendered image. With the mask m (1: included,
// 0: excluded) and the elementwise product o, the loss is evaluated at
//   m o rendered + (1 - m) o truth.
// So an excluded pixel has no error, and SSIM windows are complete. The sums of the loss run over all pixels, because
// the SSIM window around an excluded pixel may contain errors.
//
// Derivatives are exact: the gradient is m o (gradient of the loss), and the curvature is M W M with M = diag(m) and W
// the curvature of the loss. M W M is positive semidefinite too. Without a mask the result is bit-identical to the
// plain loss.
#pragma once

#include "kernels/core/check.h"
#include "kernels/core/for_each.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "problems/gaussian_splatting/scene/mask_pixels.h"

namespace vesta::gs {

inline constexpr Index kMaskGrain = 1 << 15;  // pixels per parallel task

// Throws Error if the truth is missing or does not match the size of its view.
template <class B>
void CheckTruth(const TargetView<B>& view) {
  VESTA_CHECK(view.truth.size() == view.shape().NumValues(),
              "a truth image of {} values does not match a view of {} x {}", view.truth.size(), view.camera.width,
              view.camera.height);
}

// FillMasked copies the excluded pixels of `truth` to `image`; ClearMasked sets them to zero. mask: one byte per pixel,
// 0 excludes it; empty: nothing changes. image and truth: three planes. All arrays are in the memory of B.
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

// Writes the photograph of the target, which must have transparency, over the background `to` instead of `from`.
template <class B>
void ComposeOver(const TargetView<B>& target, const double from[3], const double to[3],
                 typename B::VectorView composed) {
  using S = typename B::Scalar;
  ChangeBackground<S> change{
      target.truth.data(), target.transparency.data(), {}, composed.data(), target.transparency.size()};
  for (int c = 0; c < 3; ++c) change.change[c] = static_cast<S>(to[c] - from[c]);
  ForEach<typename B::Space>(change.plane, kMaskGrain, change);
}

// The functions of kernels/image/photometric_loss.h with the mask of the view. They replace the excluded pixels of
// `rendered`. Images are three planes; `gradient` is with respect to `rendered`.
template <class B>
PhotometricValue EvaluateLoss(typename SplatBackend<B>::Loss& loss, const TargetView<B>& target,
                              typename B::VectorView rendered) {
  FillMasked<B>(target.mask, typename B::ConstVectorView(target.truth), rendered);
  return loss.Evaluate(rendered, target.truth, target.shape());
}
// truth: the photograph of the target, or another image in its place.
template <class B>
void LossGradient(typename SplatBackend<B>::Loss& loss, const TargetView<B>& target, typename B::ConstVectorView truth,
                  typename B::VectorView rendered, typename B::VectorView gradient) {
  FillMasked<B>(target.mask, truth, rendered);
  loss.Gradient(rendered, truth, target.shape(), gradient);
  ClearMasked<B>(target.mask, gradient);
}
// `linearization` represents W, not M W M: call ClearMasked before and after each product with W. Only
// linearization.diagonal belongs to M W M.
template <class B>
void LinearizeLoss(typename SplatBackend<B>::Loss& loss, const TargetView<B>& target, typename B::VectorView rendered,
                   typename B::VectorView gradient, typename SplatBackend<B>::Loss::Linearization& linearization) {
  FillMasked<B>(target.mask, typename B::ConstVectorView(target.truth), rendered);
  loss.Linearize(rendered, target.truth, target.shape(), gradient, linearization);
  ClearMasked<B>(target.mask, gradient);
  ClearMasked<B>(target.mask, typename B::VectorView(linearization.diagonal));
}

}  // namespace vesta::gs
