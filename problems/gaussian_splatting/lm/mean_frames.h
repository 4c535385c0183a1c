// The coordinates in which steps of the means are taken: along the line of sight, and across it.
//
// A mean that moves in depth passes others in the order of compositing, which no linear model sees; across the line of
// sight the model is good (docs/results, 2026-11-21, damping). To damp the one and not the other by a diagonal metric
// the tangent space of each mean is turned so that its last axis is the mean direction from the cameras. The turn is a
// Householder reflection: its own inverse and transpose, and three numbers a Gaussian.
#pragma once

#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/gaussian_splatting/types.h"

namespace vesta::gs {

template <class S>
class MeanFrames {
 public:
  MeanFrames() = default;
  // From the means at x (structure of arrays, count of each coordinate first) and the views they are seen from. A mean
  // that no view has in its image keeps the axes of the world.
  MeanFrames(HostSpan<const S> x, Index count, const std::vector<splat::PinholeView>& views);

  bool empty() const { return normal_.empty(); }
  // v's means (entries 0 .. 3 count - 1, structure of arrays) from the frames to the world, or back: the same.
  void Reflect(HostSpan<S> v) const;
  // B = R B R for blocks of `size` rows whose first three are a mean's, packed as in BlockDiagonal.
  void ReflectBlocks(int size, HostSpan<S> blocks) const;
  // The part of motion along frame axis k (0, 1: across; 2: along) that is along lines of sight: the mean over the
  // views of the squared cosine. The three sum to one.
  S SightShare(int axis, Index i) const { return axis == 2 ? depth_share_[i] : (1 - depth_share_[i]) / 2; }

 private:
  Index count_ = 0;
  HostBuffer<S> normal_;  // unit vectors, or zero for no reflection; count of each coordinate
  HostBuffer<S> depth_share_;
};

extern template class MeanFrames<float>;
extern template class MeanFrames<double>;

}  // namespace vesta::gs
