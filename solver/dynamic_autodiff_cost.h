// SPDX-License-Identifier: Apache-2.0
// Cost functions with automatic derivatives whose sizes are set at run time.
#pragma once

#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "kernels/math/derivatives.h"
#include "solver/cost_function.h"
#include "solver/internal/autodiff_blocks.h"
#include "solver/internal/functor_call.h"

namespace vesta {

// Like AutoDiffCost, and like ceres::DynamicAutoDiffCostFunction. The functor f(blocks, r) reads block b at blocks[b],
// a const T*, and writes num_residuals values to r. One evaluation of the functor computes kDerivatives derivatives.
template <class F, int kDerivatives = 8>
class DynamicAutoDiffCost final : public CostFunction {
 public:
  DynamicAutoDiffCost(F functor, int num_residuals, std::vector<int> block_sizes)
      : CostFunction(num_residuals, std::move(block_sizes)), functor_(std::move(functor)) {}

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    if (jacobians == nullptr) return InvokeFunctor(functor_, parameters, residuals);
    Work work(*this);
    return DifferentiateBlocks(work, parameters, residuals, jacobians,
                               [&](const auto* const* from, auto* to) { return InvokeFunctor(functor_, from, to); });
  }

 private:
  using D = Dual<double, kDerivatives>;
  struct Work {
    explicit Work(const CostFunction& cost) : sizes(cost.block_sizes()), blocks(sizes.size()) {
      const auto count = static_cast<std::size_t>(std::accumulate(sizes.begin(), sizes.end(), 0));
      parameters.resize(count);
      residuals.resize(static_cast<std::size_t>(cost.num_residuals()));
      columns.resize(count);
    }
    std::size_t num_blocks() const { return sizes.size(); }
    int size(std::size_t b) const { return sizes[b]; }
    int num_residuals() const { return static_cast<int>(residuals.size()); }
    std::span<const int> sizes;
    std::vector<D> parameters, residuals;
    std::vector<const D*> blocks;
    std::vector<D*> columns;
  };
  F functor_;
};

}  // namespace vesta
