// SPDX-License-Identifier: Apache-2.0
// The body of view_curvature.h. Included where it is instantiated; where columns are not yet, after view_columns.inl.
#pragma once

#include "problems/gaussian_splatting/model/masked_loss.h"
#include "splatting/cameras/derivatives/view_columns.h"
#include "splatting/cameras/derivatives/view_curvature.h"

namespace vesta::gs {

template <class B>
std::vector<double> ViewCurvature(const FreeUnknowns& free, const std::array<double, 3>& background,
                                  const splat::Model<float>& model, const TargetView<B>& target) {
  typename SplatBackend<B>::Workspace workspace;
  typename SplatBackend<B>::SplatView view;
  view.Build(model, target.camera, background.data(), workspace);
  typename B::Vector image, image_gradient;
  image.ResizeForOverwrite(target.shape().NumValues());
  view.Render(image.data());
  const ViewColumns<B> columns =
      ColumnsOf<B>(free, {}, target, image.view(), MovesOf<B>(free, view, model, workspace).view());
  // With the mask in J, that of W need not be: J^T W J is the same.
  typename SplatBackend<B>::Loss loss;
  typename SplatBackend<B>::Loss::Linearization W;
  image_gradient.ResizeForOverwrite(image.size());
  LinearizeLoss(loss, target, image.view(), image_gradient.view(), W);
  return WeightedGram(columns, loss, W);
}

}  // namespace vesta::gs
