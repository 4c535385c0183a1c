// SPDX-License-Identifier: Apache-2.0
// Bodies of solver/internal/normal_equations/damped_normal_equations.h.
#pragma once

#include <utility>

#include "kernels/core/check.h"
#include "solver/internal/normal_equations/damped_normal_equations.h"

namespace vesta {

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
