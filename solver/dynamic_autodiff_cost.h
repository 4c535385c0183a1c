// SPDX-License-Identifier: Apache-2.0
// Cost functions with automatic derivatives whose sizes are set at run time.
#pragma once

#include <cstddef>
#include <numeric>
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
    using D = Dual<double, kDerivatives>;
    const auto count = static_cast<std::size_t>(std::accumulate(block_sizes().begin(), block_sizes().end(), 0));
    std::vector<D> numbers(count + static_cast<std::size_t>(num_residuals()));
    std::vector<const D*> blocks(block_sizes().size());
    std::vector<D*> columns(count);
    return DifferentiateBlocks<D>(block_sizes(), num_residuals(),
                                  {numbers.data(), numbers.data() + count, blocks.data(), columns.data()}, parameters,
                                  residuals, jacobians,
                                  [&](const auto* const* from, auto* to) { return InvokeFunctor(functor_, from, to); });
  }

 private:
  F functor_;
};

}  // namespace vesta
