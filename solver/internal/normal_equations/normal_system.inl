// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/internal/normal_equations/normal_system.h.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/profile.h"
#include "solver/internal/normal_equations/normal_system.h"

namespace vesta {

namespace fault_internal {

template <Backend B>
std::vector<typename B::Scalar> OnHost(B& backend, typename B::ConstVectorView x) {
  std::vector<typename B::Scalar> host(static_cast<std::size_t>(x.size()));
  backend.ToHost(x, {host.data(), x.size()});
  return host;
}

// Index of the first value that satisfies the predicate, or -1.
template <class S, class Holds>
Index FirstOf(const std::vector<S>& values, const Holds& holds) {
  const auto found = std::find_if(values.begin(), values.end(), holds);
  return found == values.end() ? -1 : static_cast<Index>(found - values.begin());
}

// "nan for entry 3 of the step (computed as NaN, or not written)".
template <Backend B>
std::string DescribeEntry(ProblemAdaptor<B> problem, const std::vector<typename B::Scalar>& values, Index k) {
  const auto value = static_cast<double>(values[static_cast<std::size_t>(k)]);
  return fmt::format("{:.3g} for {}{}", std::isnan(value) ? std::abs(value) : value, problem.NameTangent(k),
                     std::isnan(value) ? " (computed as NaN, or not written)" : "");
}

}  // namespace fault_internal

template <Backend B>
SystemFault FindFault(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView negative_gradient,
                      typename B::ConstVectorView rhs, typename B::ConstVectorView diagonal) {
  using S = typename B::Scalar;
  using Kind = SystemFault::Kind;
  const auto not_finite = [](S value) { return !std::isfinite(value); };
  const auto describe = [&](typename B::ConstVectorView values, const auto& holds) {
    const std::vector<S> host = fault_internal::OnHost(backend, values);
    return fault_internal::DescribeEntry(problem, host, fault_internal::FirstOf(host, holds));
  };
  if (!backend.AllFinite(negative_gradient)) {
    return {Kind::kNonFinite,
            "the gradient is not finite although the cost is: " + describe(negative_gradient, not_finite)};
  }
  if (!backend.AllFinite(rhs)) {
    return {Kind::kNonFinite, "the right-hand side is not finite although the cost is: " + describe(rhs, not_finite)};
  }
  if (!backend.AllFinite(diagonal)) {
    return {Kind::kDiagonal, fmt::format("DiagJTJ gives {}; it must overwrite every entry with a sum of squares",
                                         describe(diagonal, not_finite))};
  }
  if (backend.CountNonPositive(diagonal) == 0) return {};
  typename B::Vector negative(diagonal.size());
  backend.Clamp(diagonal, -std::numeric_limits<double>::infinity(), 0, negative);
  const double allowed = 64 * static_cast<double>(std::numeric_limits<S>::epsilon()) * backend.MaxAbs(diagonal);
  if (backend.MaxAbs(negative.view()) <= allowed) return {};
  return {Kind::kDiagonal,
          fmt::format("DiagJTJ gives {}; it must be a sum of squares: CheckProblem compares it with J",
                      describe(diagonal, [&](S value) { return static_cast<double>(value) < -allowed; }))};
}

template <Backend B>
std::string DescribeZeroColumnGradient(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x,
                                       typename B::ConstVectorView negative_gradient,
                                       typename B::ConstVectorView diagonal, double threshold) {
  typename B::Vector blocked(diagonal.size());
  backend.SelectPositive(diagonal, 0, 1, blocked);
  if (problem.has_bounds()) problem.MaskActiveBounds(x, negative_gradient, blocked);
  backend.Multiply(blocked, negative_gradient, blocked);
  if (backend.MaxAbs(blocked.view()) <= threshold) return "";
  const auto host = fault_internal::OnHost(backend, blocked.view());
  const Index k =
      fault_internal::FirstOf(host, [&](auto value) { return std::abs(static_cast<double>(value)) > threshold; });
  return fmt::format(
      "{} has a gradient of {:.3e}, but cannot move, because its entry of DiagJTJ is not positive: correct DiagJTJ "
      "(CheckProblem compares it with J)",
      problem.NameTangent(k), -static_cast<double>(host[static_cast<std::size_t>(k)]));
}

template <Backend B>
double UnderflowGradient(Index num_residuals, double cost) {
  constexpr double kSafety = 1e3;
  const auto smallest = static_cast<double>(std::numeric_limits<typename B::Scalar>::min());
  return kSafety * std::sqrt(smallest * static_cast<double>(num_residuals)) * std::sqrt(2 * cost);
}

template <Backend B>
NormalSystem<B>::NormalSystem(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x,
                              const std::vector<int>& batches)
    : backend_(backend), problem_(problem) {
  const Index n = problem.num_tangent();
  for (typename B::Vector* vector : {&negative_gradient_, &diagonal_}) vector->ResizeForOverwrite(n);
  typename B::Vector part;  // values of one batch after the first
  // Entries that the problem does not write stay NaN.
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
    if (batches_.size() == 1 && linearization.has_own_right_hand_side()) rhs_.ResizeForOverwrite(n);
    if (!rhs_.empty()) add([&](typename B::VectorView d) { linearization.RightHandSide(d); }, rhs_);
    phase.Next("diagonal");
    add([&](typename B::VectorView d) { linearization.DiagJTJ(d); }, diagonal_);
  }
  backend_.Axpby(-1.0, negative_gradient_, 0.0, negative_gradient_);
  fault_ = FindFault<B>(backend_, problem_, negative_gradient(), rhs_.view(), diagonal());
  num_zero_columns_ = backend_.CountNonPositive(diagonal_);
}

template <Backend B>
Index NormalSystem<B>::num_residuals() const {
  Index sum = 0;
  for (const auto& batch : batches_) sum += batch->num_residuals();
  return sum;
}

template <Backend B>
void NormalSystem<B>::Prepare(const NormalSystemOptions& options, typename B::ConstVectorView x,
                              const ColumnScale<B>& scale, bool keep_diagonal, bool describe) {
  metric_.Resize(diagonal_.size());
  if (!problem_.DampingMetric(x, diagonal_.view(), metric_)) {
    DiagonalMetric(options.metric, backend_, diagonal_.view(), scale, pointers_.front()->block_groups(),
                   metric_.view());
  }
  if (num_zero_columns_ > 0 || problem_.has_bounds()) {
    mask_.Resize(diagonal_.size());
    backend_.SelectPositive(diagonal_, 1, 0, mask_);
    if (problem_.has_bounds()) problem_.MaskActiveBounds(x, negative_gradient(), mask_);
    backend_.Multiply(mask_, negative_gradient_, negative_gradient_);
    if (!rhs_.empty()) backend_.Multiply(mask_, rhs_, rhs_);
  }
  solver_ = MakeStepSolver<B>(options,
                              {backend_, problem_, pointers_, diagonal_.view(), metric_.view(), mask_.view(), rhs(),
                               negative_gradient(), scale},
                              describe);
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
