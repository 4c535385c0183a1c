// SPDX-License-Identifier: Apache-2.0
// What a joint problem and its linearizations go through their views in, one call at a time.
#pragma once

#include "problems/gaussian_splatting/model/splat_backend.h"

namespace vesta::gs {

template <class B>
class JointScratch {
 public:
  using Vector = typename B::Vector;
  using VectorView = typename B::VectorView;

  explicit JointScratch(const PhotometricWeights& weights) : loss(weights) {}

  typename SplatBackend<B>::Loss loss;
  typename SplatBackend<B>::Workspace workspace;
  // Images of so many values, each until it is asked for again.
  VectorView Image(Index values) { return Of(values, image_); }
  VectorView Weighted(Index values) { return Of(values, weighted_); }

 private:
  static VectorView Of(Index values, Vector& images) {
    if (images.size() < values) images.ResizeForOverwrite(values);
    return images.view().subspan(0, values);
  }

  Vector image_, weighted_;
};

}  // namespace vesta::gs
