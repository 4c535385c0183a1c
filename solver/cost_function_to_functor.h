// SPDX-License-Identifier: Apache-2.0
// Calls a cost function from a functor with automatic derivatives.
#pragma once

#include <cstddef>
#include <memory>
#include <numeric>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/math/derivatives.h"
#include "solver/cost_function.h"

namespace vesta {

// A functor with the residuals and derivatives of a cost function, like ceres::CostFunctionToFunctor and
// DynamicCostFunctionToFunctor. Functors of AutoDiffCost can then combine it with other operations:
//   bool operator()(const T* camera, const T* point, T* r) const { return project_(camera, point, r) && ...; }
// The functor computes derivatives by the chain rule. They are exact if the derivatives of the cost function are exact.
class CostFunctionToFunctor {
 public:
  // Throws Error if cost is null.
  explicit CostFunctionToFunctor(std::shared_ptr<const CostFunction> cost) : cost_(std::move(cost)) {
    VESTA_CHECK(cost_ != nullptr, "the cost function is null");
  }

  // blocks[b] contains block b. Writes the residuals. Returns false if the cost function returns false. T is double or
  // a dual number.
  template <class T>
  bool operator()(const T* const* blocks, T* residuals) const {
    if constexpr (std::is_same_v<T, double>) {
      return cost_->Evaluate(blocks, residuals, nullptr);
    } else {
      return Differentiate(blocks, residuals);
    }
  }
  // The same with one pointer per block, followed by the residuals. Throws Error if the number of blocks is wrong.
  template <class T, class... Pointers>
  requires(sizeof...(Pointers) > 0) bool operator()(const T* first, Pointers... others) const {
    const T* const blocks[] = {first, others...};
    VESTA_CHECK(sizeof...(Pointers) == cost_->block_sizes().size(), "the cost function has {} parameter blocks, not {}",
                cost_->block_sizes().size(), sizeof...(Pointers));
    return (*this)(static_cast<const T* const*>(blocks), Last(others...));
  }

 private:
  template <class T>
  static T Last(T last) {
    return last;
  }
  template <class T, class... More>
  static auto Last(T, More... more) {
    return Last(more...);
  }

  template <class T>
  bool Differentiate(const T* const* blocks, T* residuals) const {
    const std::span<const int> sizes = cost_->block_sizes();
    const auto rows = static_cast<std::size_t>(cost_->num_residuals());
    const auto total = static_cast<std::size_t>(std::accumulate(sizes.begin(), sizes.end(), 0));
    // The values of all blocks, the residuals, and the Jacobians of all blocks.
    std::vector<double> numbers(total + rows + rows * total);
    std::vector<const double*> parameters(sizes.size());
    std::vector<double*> jacobians(sizes.size());
    double* value = numbers.data();
    double* const result = value + total;
    double* jacobian = result + rows;
    for (std::size_t b = 0; b < sizes.size(); ++b) {
      parameters[b] = value;
      jacobians[b] = jacobian;
      for (int i = 0; i < sizes[b]; ++i) *value++ = blocks[b][i].a;
      jacobian += rows * static_cast<std::size_t>(sizes[b]);
    }
    if (!cost_->Evaluate(parameters.data(), result, jacobians.data())) return false;
    for (std::size_t row = 0; row < rows; ++row) {
      residuals[row] = T(result[row]);
      for (std::size_t b = 0; b < sizes.size(); ++b) {
        const double* const derivatives = jacobians[b] + row * static_cast<std::size_t>(sizes[b]);
        for (int i = 0; i < sizes[b]; ++i) residuals[row].v = residuals[row].v + derivatives[i] * blocks[b][i].v;
      }
    }
    return true;
  }

  std::shared_ptr<const CostFunction> cost_;
};

}  // namespace vesta
