// What a joint problem, its parts and their linearizations go through their views in, one call at a time.
#pragma once

#include "kernels/core/buffer.h"
#include "kernels/gaussian_splatting/splat_view.h"
#include "kernels/image/photometric_loss.h"

namespace vesta::gs {

template <class S>
class JointScratch {
 public:
  explicit JointScratch(const PhotometricWeights& weights) : loss(weights) {}

  PhotometricLoss<S> loss;
  splat::ViewWorkspace<S> workspace;
  // Images of so many values, each until it is asked for again.
  HostSpan<S> Image(Index values) { return Of(values, image_); }
  HostSpan<S> Weighted(Index values) { return Of(values, weighted_); }
  HostSpan<S> Column(Index values) { return Of(values, column_); }

 private:
  static HostSpan<S> Of(Index values, HostBuffer<S>& images) {
    if (images.size() < values) images.ResizeForOverwrite(values);
    return images.view().subspan(0, values);
  }

  HostBuffer<S> image_, weighted_, column_;
};

}  // namespace vesta::gs
