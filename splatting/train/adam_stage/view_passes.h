// SPDX-License-Identifier: Apache-2.0
// The passes over one view: from a model to the gradient of the view's cost.
#pragma once

#include "problems/gaussian_splatting/model/masked_loss.h"
#include "splatting/distributed/sum_of_views.h"

namespace vesta::gs {

// What the passes work in, and leave there.
template <class B>
struct ViewPasses {
  // |e| itself, as in 3DGS: Adam needs no floor.
  typename SplatBackend<B>::Loss loss{PhotometricWeights{.l1_floor = 0}};
  typename SplatBackend<B>::SplatView view;
  typename SplatBackend<B>::Workspace workspace;
  typename B::Vector image, image_gradient;
  SumOfViews<typename B::Space> views;  // of an iteration

  // Adds the gradient of the cost, which loss.Value() has.
  void AddGradient(const splat::Model<float>& x, const TargetView<B>& target, const double* background,
                   float* gradient) {
    const ImageShape shape = target.shape();
    image.ResizeForOverwrite(shape.NumValues());
    image_gradient.ResizeForOverwrite(shape.NumValues());
    view.Build(x, target.camera, background, workspace);
    view.Render(image.data());
    LossGradient(loss, target, image.view(), image_gradient.view());
    view.AddJT(x, image.data(), image_gradient.data(), gradient, workspace);
  }
};

}  // namespace vesta::gs
