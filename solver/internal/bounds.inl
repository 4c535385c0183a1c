// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/bounds.h.
#pragma once

#include <algorithm>
#include <utility>

#include "kernels/core/check.h"
#include "solver/bounds.h"
#include "solver/internal/normal_equations/preconditioner.h"

namespace vesta {

template <Backend B>
BoundedProblem<B>::BoundedProblem(Problem<B>& inner, std::vector<double> lower, std::vector<double> upper)
    : inner_(inner), lower_(std::move(lower)), upper_(std::move(upper)) {
  const auto n = static_cast<std::size_t>(inner_.num_parameters());
  VESTA_CHECK(inner_.num_tangent() == inner_.num_parameters(),
              "BoundedProblem needs steps of the size of x; x has {} entries, a step {}", inner_.num_parameters(),
              inner_.num_tangent());
  VESTA_CHECK(lower_.size() == n && upper_.size() == n, "{} lower and {} upper bounds for {} parameters", lower_.size(),
              upper_.size(), n);
  for (std::size_t k = 0; k < n; ++k) {
    if (!(lower_[k] <= upper_[k])) {
      Fail(kBadArgument, "parameter {}: the lower bound {} is above the upper bound {}", k, lower_[k], upper_[k]);
    }
  }
}

template <Backend B>
std::vector<typename B::Scalar> BoundedProblem<B>::Host(ConstVectorView x) const {
  std::vector<S> host(static_cast<std::size_t>(x.size()));
  B().ToHost(x, {host.data(), x.size()});
  return host;
}

template <Backend B>
std::unique_ptr<Preconditioner<B>> BoundedProblem<B>::MakePreconditioner() {
  return inner_.MakePreconditioner();
}

template <Backend B>
std::unique_ptr<Preconditioner<B>> BoundedProblem<B>::MakeSparseCholesky() {
  return inner_.MakeSparseCholesky();
}

template <Backend B>
double BoundedProblem<B>::VariableNorm(ConstVectorView x) {
  B backend;
  return inner_.VariableNorm(backend, x);
}

template <Backend B>
double BoundedProblem<B>::VariableMaxChange(ConstVectorView x, VectorView y) {
  B backend;
  return inner_.VariableMaxChange(backend, x, y);
}

template <Backend B>
void BoundedProblem<B>::Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) {
  inner_.Plus(backend, x, delta, out);
  std::vector<S> host = Host(out);
  for (std::size_t k = 0; k < host.size(); ++k) {
    // NaN stays NaN: the cost is then not finite, and the step is rejected.
    host[k] = static_cast<S>(std::min(std::max(static_cast<double>(host[k]), lower_[k]), upper_[k]));
  }
  backend.FromHost({host.data(), out.size()}, out);
}

template <Backend B>
std::string BoundedProblem<B>::DescribeInfeasible(ConstVectorView x) {
  const std::vector<S> host = Host(x);
  for (std::size_t k = 0; k < host.size(); ++k) {
    const auto value = static_cast<double>(host[k]);
    if (bounds_internal::Inside(value, lower_[k], upper_[k])) continue;
    return fmt::format("entry {}: {}", k, bounds_internal::Outside(value, lower_[k], upper_[k]));
  }
  return "";
}

template <Backend B>
void BoundedProblem<B>::MaskActiveBounds(ConstVectorView x, ConstVectorView negative_gradient, VectorView mask) {
  const std::vector<S> at = Host(x), pull = Host(negative_gradient);
  std::vector<S> host = Host(mask);
  for (std::size_t k = 0; k < host.size(); ++k) {
    const bool held =
        bounds_internal::PushedOut(static_cast<double>(at[k]), static_cast<double>(pull[k]), lower_[k], upper_[k]);
    if (held) host[k] = S(0);
  }
  B().FromHost({host.data(), mask.size()}, mask);
}

template <Backend B>
void BoundedProblem<B>::ClipStep(ConstVectorView x, VectorView step) {
  const std::vector<S> at = Host(x);
  std::vector<S> host = Host(step);
  for (std::size_t k = 0; k < host.size(); ++k) {
    host[k] = static_cast<S>(
        bounds_internal::ClippedStep(static_cast<double>(at[k]), static_cast<double>(host[k]), lower_[k], upper_[k]));
  }
  B().FromHost({host.data(), step.size()}, step);
}

}  // namespace vesta
