// SPDX-License-Identifier: Apache-2.0
// Bodies of solver/internal/normal_equations/system_fault.h.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "solver/internal/normal_equations/system_fault.h"

namespace vesta {

namespace fault_internal {

template <Backend B>
std::vector<typename B::Scalar> OnHost(B& backend, typename B::ConstVectorView x) {
  std::vector<typename B::Scalar> host(static_cast<std::size_t>(x.size()));
  backend.ToHost(x, {host.data(), x.size()});
  return host;
}

// The first entry for which it holds, or -1.
template <class S, class Holds>
Index FirstOf(const std::vector<S>& values, const Holds& holds) {
  const auto found = std::find_if(values.begin(), values.end(), holds);
  return found == values.end() ? -1 : static_cast<Index>(found - values.begin());
}

// "nan for entry 3 of the step (computed so, or not written)".
template <Backend B>
std::string DescribeEntry(ProblemAdaptor<B> problem, const std::vector<typename B::Scalar>& values, Index k) {
  const auto value = static_cast<double>(values[static_cast<std::size_t>(k)]);
  return fmt::format("{:.3g} for {}{}", std::isnan(value) ? std::abs(value) : value, problem.NameTangent(k),
                     std::isnan(value) ? " (computed so, or not written)" : "");
}

}  // namespace fault_internal

template <Backend B>
SystemFault FindFault(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView negative_gradient,
                      typename B::ConstVectorView descent, typename B::ConstVectorView diagonal) {
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
  if (!backend.AllFinite(descent)) {
    return {Kind::kNonFinite, "the descent is not finite although the cost is: " + describe(descent, not_finite)};
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
std::string DescribeFrozenGradient(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x,
                                   typename B::ConstVectorView negative_gradient, typename B::ConstVectorView diagonal,
                                   double threshold) {
  typename B::Vector frozen(diagonal.size());
  backend.SelectPositive(diagonal, 0, 1, frozen);
  if (problem.has_bounds()) problem.MaskActiveBounds(x, negative_gradient, frozen);
  backend.Multiply(frozen, negative_gradient, frozen);
  if (backend.MaxAbs(frozen.view()) <= threshold) return "";
  const auto host = fault_internal::OnHost(backend, frozen.view());
  const Index k =
      fault_internal::FirstOf(host, [&](auto value) { return std::abs(static_cast<double>(value)) > threshold; });
  return fmt::format(
      "{} has a gradient of {:.3e}, but cannot move, for its entry of DiagJTJ is not positive: correct DiagJTJ "
      "(CheckProblem compares it with J)",
      problem.NameTangent(k), -static_cast<double>(host[static_cast<std::size_t>(k)]));
}

template <Backend B>
double UnderflownGradient(Index num_residuals, double cost) {
  constexpr double kRoom = 1e3;
  const auto smallest = static_cast<double>(std::numeric_limits<typename B::Scalar>::min());
  return kRoom * std::sqrt(smallest * static_cast<double>(num_residuals)) * std::sqrt(2 * cost);
}

}  // namespace vesta
