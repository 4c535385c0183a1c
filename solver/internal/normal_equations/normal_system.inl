// SPDX-License-Identifier: Apache-2.0
// Bodies of solver/internal/normal_equations/normal_system.h.
#pragma once

#include <limits>

#include "kernels/core/check.h"
#include "kernels/core/profile.h"
#include "solver/internal/normal_equations/normal_system.h"
#include "solver/internal/normal_equations/system_fault.inl"

namespace vesta {

template <Backend B>
NormalSystem<B>::NormalSystem(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x,
                              const std::vector<int>& batches)
    : backend_(backend), problem_(problem) {
  const Index n = problem.num_tangent();
  for (typename B::Vector* vector : {&negative_gradient_, &diagonal_}) vector->ResizeForOverwrite(n);
  typename B::Vector part;  // of one batch after the first
  // What the problem does not write stays NaN.
  const auto fill = [&](auto&& give, typename B::VectorView to) {
    backend_.Fill(std::numeric_limits<double>::quiet_NaN(), to);
    give(to);
  };
  const auto add = [&](auto&& give, typename B::Vector& sum) {
    if (batches_.size() == 1) return fill(give, sum.view());
    if (part.empty()) part.ResizeForOverwrite(n);
    fill(give, part.view());
    backend_.Axpby(1.0, part, 1.0, sum);
  };
  for (const int batch : batches) {
    batches_.push_back(problem.CheckedLinearize(x, batch));
    pointers_.push_back(batches_.back().get());
    LinearizationAdaptor<B>& linearization = *batches_.back();
    ScopedPhase phase("gradient");
    add([&](typename B::VectorView g) { linearization.Gradient(g); }, negative_gradient_);
    if (batches_.size() == 1 && linearization.has_own_descent()) descent_.ResizeForOverwrite(n);
    if (!descent_.empty()) add([&](typename B::VectorView d) { linearization.Descent(d); }, descent_);
    phase.Next("diagonal");
    add([&](typename B::VectorView d) { linearization.DiagJTJ(d); }, diagonal_);
  }
  backend_.Axpby(-1.0, negative_gradient_, 0.0, negative_gradient_);
  fault_ = FindFault<B>(backend_, problem_, negative_gradient(), descent_.view(), diagonal());
  num_frozen_ = backend_.CountNonPositive(diagonal_);
}

template <Backend B>
Index NormalSystem<B>::num_residuals() const {
  Index sum = 0;
  for (const auto& batch : batches_) sum += batch->num_residuals();
  return sum;
}

template <Backend B>
void NormalSystem<B>::Prepare(const NormalSystemOptions& options, typename B::ConstVectorView x,
                              const ColumnScale<B>& scale, bool keep_diagonal) {
  metric_.Resize(diagonal_.size());
  if (!problem_.DampingMetric(x, diagonal_.view(), metric_)) {
    DiagonalMetric(options.metric, backend_, diagonal_.view(), scale, pointers_.front()->block_groups(),
                   metric_.view());
  }
  if (num_frozen_ > 0 || problem_.has_bounds()) {
    mask_.Resize(diagonal_.size());
    backend_.SelectPositive(diagonal_, 1, 0, mask_);
    if (problem_.has_bounds()) problem_.MaskActiveBounds(x, negative_gradient(), mask_);
    backend_.Multiply(mask_, negative_gradient_, negative_gradient_);
    if (!descent_.empty()) backend_.Multiply(mask_, descent_, descent_);
  }
  solver_ = MakeStepSolver<B>(options, {backend_, problem_, pointers_, diagonal_.view(), metric_.view(), mask_.view(),
                                        rhs(), negative_gradient(), scale});
  if (!keep_diagonal && !solver_->reads_diagonal()) diagonal_ = {};
  if (!solver_->reads_mask()) mask_ = {};
}

template <Backend B>
StepSolution NormalSystem<B>::Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step) {
  VESTA_CHECK(solver_ != nullptr, "NormalSystem::Prepare comes before Solve");
  return solver_->Solve(lambda, workspace, step);
}

template <Backend B>
double NormalSystem<B>::Curvature(typename B::ConstVectorView v) {
  const ScopedPhase phase("product");
  double sum = 0;
  for (const auto& batch : batches_) sum += batch->Curvature(v);
  return sum;
}

}  // namespace vesta
