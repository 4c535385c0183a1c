// SPDX-License-Identifier: Apache-2.0
// Data that a BundleProblem shares with its linearizations, and CameraSums, which adds values per camera in parallel.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/buffer.h"
#include "kernels/core/parallel.h"
#include "problems/bundle_adjustment/bundle_problem.h"
#include "problems/bundle_adjustment/projection.h"
#include "problems/bundle_adjustment/structure.h"

namespace vesta::bundle::internal {

class ReducedCholeskyPlan;

using Cpu = CpuBackend<double>;

// Arrays of one linearization (kernels.h).
template <class S>
struct LinearizationArrays {
  HostBuffer<S> records;
  HostBuffer<double> residuals, gradient, point_products;
  HostBuffer<double> camera_gram;  // kCameraGramSize entries per camera
  HostBuffer<double> point_gram;   // entry k of point i at k * num_points + i, as in BlockDiagonal
};

// Arrays of one reduced system (reduced.h).
struct ReducedArrays {
  std::optional<BlockDiagonal<Cpu>> point_blocks;
  HostBuffer<double> inverse;  // inverse of the damped block of each point, kPointGramSize entries
  HostBuffer<double> blocks;   // blocks of the matrix, in the order of the pattern
};

// Large arrays that are no longer in use, for the next linearization or reduced system.
template <class Arrays>
class ArrayPool {
 public:
  std::unique_ptr<Arrays> Get() {
    if (free_.empty()) return std::make_unique<Arrays>();
    auto arrays = std::move(free_.back());
    free_.pop_back();
    return arrays;
  }
  void Return(std::unique_ptr<Arrays> arrays) { free_.push_back(std::move(arrays)); }

 private:
  std::vector<std::unique_ptr<Arrays>> free_;
};

struct BundleContext {
  BundleContext(const BundleData& data, BundleProblemOptions given);

  template <class S>
  ArrayPool<LinearizationArrays<S>>& pool() {
    if constexpr (sizeof(S) == sizeof(float)) {
      return float_pool;
    } else {
      return double_pool;
    }
  }

  BundleProblemOptions options;
  Structure structure;
  // The blocks of the reduced matrix to form: all, or only the diagonal ones for the preconditioner.
  ReducedPattern pattern;
  std::shared_ptr<ReducedCholeskyPlan> cholesky;  // null: the preconditioner is the diagonal blocks
  ArrayPool<LinearizationArrays<float>> float_pool;
  ArrayPool<LinearizationArrays<double>> double_pool;
  ArrayPool<ReducedArrays> reduced_pool;
};

// Prepares the cameras of x for projection.
HostBuffer<Camera<double>> MakeCameras(const Structure& structure, Cpu::ConstVectorView x);

// S: type of the stored Jacobian.
template <class S>
std::unique_ptr<Linearization<Cpu>> MakeLinearization(BundleContext& context, Cpu::ConstVectorView x);

}  // namespace vesta::bundle::internal

namespace vesta::bundle {

inline constexpr Index kCamerasPerTask = 256;  // cameras per parallel task

// Copies the camera parameters of x to the padded vector (kernels.h). Each camera has twelve entries: the nine
// parameters go to the last nine, and the first three are not written.
inline void PadCameras(Index num_cameras, const double* x, double* padded) {
  ParallelFor(num_cameras, kCamerasPerTask,
              [&](Index i) { std::copy_n(x + kCameraSize * i, kCameraSize, padded + kRowSize * i + kPointSize); });
}

// Sums nine values per camera over the points, in parallel. Each chunk of points has its own padded sums, which are
// then added in order. The number of chunks is fixed, so the result does not depend on the number of threads.
class CameraSums {
 public:
  CameraSums(Index num_cameras, Index num_chunks)
      : num_cameras_(num_cameras), num_chunks_(num_chunks), sums_(num_cameras * kRowSize * num_chunks) {}

  // Calls add(chunk, sums) for all chunks in parallel; `sums` has 12 zeros per camera. Then calls finish(camera, nine
  // totals) for all cameras in parallel.
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
