// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/internal/normal_equations/damped_normal_equations.h.
#pragma once

#include <algorithm>
#include <limits>
#include <utility>

#include "kernels/core/check.h"
#include "solver/internal/normal_equations/damped_normal_equations.h"

namespace vesta {

template <Backend B>
ColumnScale<B> MakeColumnScale(ColumnScaling scaling, B& backend, typename B::ConstVectorView diag_h) {
  ColumnScale<B> scale;
  if (scaling == ColumnScaling::kNone) return scale;
  scale.square.Resize(diag_h.size());
  scale.inverse_square.Resize(diag_h.size());
  auto& inverse = scale.inverse_square;
  switch (scaling) {
    case ColumnScaling::kNone:
      break;
    case ColumnScaling::kInverseRoot:
      backend.SelectPositive(diag_h, 0, 1, inverse);
      backend.Axpby(1.0, diag_h, 1.0, inverse);
      break;
    case ColumnScaling::kOnePlusInverse:
      backend.Sqrt(diag_h, scale.square);
      backend.Fill(1, inverse);
      backend.Axpby(1.0, scale.square, 1.0, inverse);
      backend.Multiply(inverse, inverse, inverse);
      break;
  }
  backend.ClampedInverse(inverse, 0, std::numeric_limits<double>::infinity(), scale.square);
  return scale;
}

namespace damping_internal {

// floor_k = factor times the median of the positive values of d in the same component of k's group; 0 without such
// values.
template <class S>
void GroupMedianFloor(double factor, const std::vector<BlockGroup>& groups, const std::vector<S>& d,
                      std::vector<S>& floor) {
  std::vector<S> positive;
  for (const BlockGroup& group : groups) {
    for (int c = 0; c < group.size; ++c) {
      positive.clear();
      for (Index i = 0; i < group.count; ++i) {
        const S value = d[static_cast<std::size_t>(group.Parameter(i, c))];
        if (value > S(0)) positive.push_back(value);
      }
      if (positive.empty()) continue;
      const auto middle = positive.begin() + static_cast<std::ptrdiff_t>(positive.size() / 2);
      std::nth_element(positive.begin(), middle, positive.end());
      const S value = static_cast<S>(factor) * *middle;
      for (Index i = 0; i < group.count; ++i) floor[static_cast<std::size_t>(group.Parameter(i, c))] = value;
    }
  }
}

}  // namespace damping_internal

template <Backend B>
void DiagonalMetric(const DampingMetricOptions& options, B& backend, typename B::ConstVectorView diag_h,
                    const ColumnScale<B>& scale, const std::vector<BlockGroup>& groups, typename B::VectorView metric) {
  typename B::Vector ones;
  if (scale.inverse_square.empty()) {
    ones.Resize(diag_h.size());
    backend.Fill(1, ones);
  }
  backend.ClampRelative(diag_h, ones.empty() ? scale.inverse_square.view() : ones.view(), options.min_diagonal,
                        options.max_diagonal, metric);
  if (options.group_median_floor <= 0 || groups.empty()) return;
  using S = typename B::Scalar;
  std::vector<S> d(static_cast<std::size_t>(diag_h.size())), floor(d.size(), S(0));
  backend.ToHost(diag_h, {d.data(), diag_h.size()});
  damping_internal::GroupMedianFloor(options.group_median_floor, groups, d, floor);
  typename B::Vector device_floor(diag_h.size());
  backend.FromHost({floor.data(), diag_h.size()}, device_floor);
  backend.Maximum(device_floor, metric);
}

template <Backend B>
DampedNormalEquations<B>::DampedNormalEquations(std::vector<LinearizationAdaptor<B>*> batches, double lambda,
                                                typename B::ConstVectorView metric, typename B::ConstVectorView mask)
    : batches_(std::move(batches)), lambda_(lambda), metric_(metric), mask_(mask) {
  VESTA_CHECK(!batches_.empty(), "normal equations of no batches");
  size_ = batches_.front()->num_parameters();
  if (batches_.size() > 1) work_.Resize(size_);
}

template <Backend B>
void DampedNormalEquations<B>::Apply(typename B::ConstVectorView x, typename B::VectorView y) {
  B backend;
  batches_.front()->ApplyH(x, y);
  for (std::size_t b = 1; b < batches_.size(); ++b) {
    batches_[b]->ApplyH(x, work_);
    backend.Axpby(1.0, work_, 1.0, y);
  }
  if (!mask_.empty()) backend.Multiply(mask_, y, y);
  if (lambda_ != 0) backend.AddScaled(lambda_, metric_, x, y);
}

}  // namespace vesta
