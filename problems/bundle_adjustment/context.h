// SPDX-License-Identifier: Apache-2.0
// What a bundle problem and its linearizations share.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "problems/bundle_adjustment/bundle_problem.h"
#include "problems/bundle_adjustment/reduced_cholesky.h"

namespace vesta::bundle::internal {

using Cpu = CpuBackend<double>;

// Arrays of one linearization. They are large, so the next linearization reuses them.
template <class S>
struct LinearizationArrays {
  HostBuffer<S> records;
  HostBuffer<double> residuals, gradient, point_products;
  HostBuffer<double> camera_gram;  // kCameraGramSize a camera
  HostBuffer<double> point_gram;   // entry k of point i at k * num_points + i: as BlockDiagonal has it
};

template <class S>
class ArrayPool {
 public:
  std::unique_ptr<LinearizationArrays<S>> Take() {
    if (free_.empty()) return std::make_unique<LinearizationArrays<S>>();
    auto arrays = std::move(free_.back());
    free_.pop_back();
    return arrays;
  }
  void GiveBack(std::unique_ptr<LinearizationArrays<S>> arrays) { free_.push_back(std::move(arrays)); }

 private:
  std::vector<std::unique_ptr<LinearizationArrays<S>>> free_;
};

struct BundleContext {
  BundleContext(const BundleData& data, BundleProblemOptions given);

  template <class S>
  ArrayPool<S>& pool() {
    if constexpr (sizeof(S) == sizeof(float)) {
      return float_pool;
    } else {
      return double_pool;
    }
  }

  BundleProblemOptions options;
  Structure structure;
  // The blocks of the reduced matrix that are formed: the diagonal ones, for the preconditioner, or all.
  ReducedPattern pattern;
  std::shared_ptr<ReducedCholeskyPlan> cholesky;  // null: conjugate gradients with the diagonal blocks
  ArrayPool<float> float_pool;
  ArrayPool<double> double_pool;
};

// The cameras of x, ready for projection.
HostBuffer<Camera<double>> MakeCameras(const Structure& structure, Cpu::ConstVectorView x);

// The linearization at x, the Jacobian stored in S.
template <class S>
std::unique_ptr<Linearization<Cpu>> MakeLinearization(BundleContext& context, Cpu::ConstVectorView x);

}  // namespace vesta::bundle::internal
