// SPDX-License-Identifier: Apache-2.0
// The cameras' parts of vectors: padded for the passes, and summed over chunks of points.
#pragma once

#include <algorithm>

#include "kernels/core/buffer.h"
#include "kernels/core/parallel.h"
#include "problems/bundle_adjustment/projection.h"
#include "problems/bundle_adjustment/structure.h"

namespace vesta::bundle {

inline constexpr Index kCamerasPerTask = 256;

// padded: twelve entries a camera, of which the first three stay as they are.
inline void PadCameras(Index num_cameras, const double* x, double* padded) {
  ParallelFor(num_cameras, kCamerasPerTask,
              [&](Index i) { std::copy_n(x + kCameraSize * i, kCameraSize, padded + kRowSize * i + kPointSize); });
}

// Padded sums by camera over all points: one partial sum for each of a fixed number of chunks, added in order.
class CameraSums {
 public:
  CameraSums(Index num_cameras, Index num_chunks)
      : num_cameras_(num_cameras), num_chunks_(num_chunks), sums_(num_cameras * kRowSize * num_chunks) {}

  // Calls add(chunk, sums) for all chunks, sums zero, in parallel; then finish(camera, nine sums) for all cameras.
  template <class Add, class Finish>
  void Run(const Add& add, const Finish& finish) {
    const Index size = num_cameras_ * kRowSize;
    ParallelFor(num_chunks_, 1, [&](Index chunk) {
      double* sums = sums_.data() + chunk * size;
      std::fill_n(sums, size, 0.0);
      add(chunk, sums);
    });
    ParallelFor(num_cameras_, kCamerasPerTask, [&](Index i) {
      double total[kCameraSize] = {};
      for (Index chunk = 0; chunk < num_chunks_; ++chunk) {
        const double* part = sums_.data() + chunk * size + kRowSize * i + kPointSize;
        for (int c = 0; c < kCameraSize; ++c) total[c] += part[c];
      }
      finish(i, total);
    });
  }

 private:
  Index num_cameras_, num_chunks_;
  HostBuffer<double> sums_;
};

}  // namespace vesta::bundle
