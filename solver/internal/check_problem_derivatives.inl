// SPDX-License-Identifier: Apache-2.0
// The derivative checks of solver/internal/check_problem.inl, which includes this file.
#pragma once

#include "solver/internal/check_problem.inl"
#include "solver/internal/step_differences.h"

namespace vesta::check_internal {

template <Backend B>
typename B::Vector ProblemChecker<B>::ScaledDirection(ConstVectorView diagonal, std::uint64_t seed) const {
  const std::vector<double> random = OnHost(Random(n_, seed).view()), squares = OnHost(diagonal);
  std::vector<S> host(random.size());
  for (std::size_t k = 0; k < host.size(); ++k) {
    host[k] = static_cast<S>(random[k] / (squares[k] > 0 ? std::sqrt(squares[k]) : 1.0));
  }
  Vector v(n_);
  backend_.FromHost({host.data(), n_}, v);
  return v;
}

template <Backend B>
void ProblemChecker<B>::DropBounded(double length, Vector& v) const {
  if (!problem_.has_bounds()) return;
  Vector step(n_);
  for (const double sign : {1.0, -1.0}) {
    backend_.Axpby(sign * length, v, 0.0, step);
    const std::vector<double> before = OnHost(step.view());
    problem_.ClipStep(x_, step);
    const std::vector<double> after = OnHost(step.view());
    for (std::size_t k = 0; k < before.size(); ++k) {
      if (before[k] != after[k]) backend_.Fill(0, v.view().subspan(static_cast<Index>(k), 1));
    }
  }
}

template <Backend B>
typename ProblemChecker<B>::Mismatch ProblemChecker<B>::Compare(const Derivative& derivative, ConstVectorView v) const {
  // Largest step: changes the residuals by a tenth of their norm.
  const double slope = std::sqrt(std::max(0.0, backend_.WeightedDot(derivative.diagonal, v, v)));
  const double largest = derivative.length > 0 && slope > 0
                             ? 0.1 * derivative.length / slope
                             : 0.1 * (Norm(x_) + 1) / std::max(Norm(v), std::numeric_limits<double>::min());
  Vector along(n_), step(n_), moved(problem_.num_parameters());
  backend_.Copy(v, along);
  DropBounded(largest, along);
  const double length = Norm(along.view());
  if (length == 0) return {};
  const std::vector<double> given = derivative.given(along);
  const StepDifferences differences = DifferenceAlong(
      [&](double t, std::span<double> out) {
        backend_.Axpby(t, along, 0.0, step);
        problem_.Plus(backend_, x_, step, moved.view());
        derivative.value(moved, out);
      },
      given.size(), largest, static_cast<double>(std::numeric_limits<S>::epsilon()), Norm(x_) / length);
  double size = 0;
  for (const double value : given) size = std::max(size, std::abs(value));
  Mismatch worst;
  double excess = 0;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const double value = differences.value[i];
    const double allowed =
        options_.derivatives * std::max({std::abs(given[i]), std::abs(value), 1e-3 * size}) + 10 * differences.error[i];
    const double beyond = std::abs(given[i] - value) - allowed;
    if (beyond > excess) worst = {static_cast<Index>(i), given[i], value}, excess = beyond;
  }
  return worst;
}

template <Backend B>
void ProblemChecker<B>::CheckDerivative(const Derivative& derivative,
                                        const std::function<void(Index k, const Mismatch&)>& say) {
  constexpr int kDirections = 2, kNamed = 3;
  Mismatch found;
  for (int d = 0; d < kDirections && found.entry < 0; ++d) {
    found = Compare(derivative, ScaledDirection(derivative.diagonal, 10 + static_cast<std::uint64_t>(d)));
  }
  if (found.entry < 0) return;
  int named = 0;
  for (Index k = 0; k < n_ && named < kNamed; k += stride_) {
    const Mismatch single = Compare(derivative, Unit(k));
    if (single.entry < 0) continue;
    say(k, single);
    ++named;
  }
  if (named == 0) say(-1, found);
}

template <Backend B>
void ProblemChecker<B>::CheckTangent(int batch, LinearizationAdaptor<B>& linearization) {
  Vector Jv(linearization.num_residuals()), diagonal(n_);
  linearization.DiagJTJ(diagonal);
  const auto given = [&](ConstVectorView v) {
    linearization.ApplyJ(v, Jv);
    return OnHost(Jv.view());
  };
  const auto value = [&](ConstVectorView moved, std::span<double> out) {
    const std::vector<double> residuals = OnHost(problem_.CheckedLinearize(moved, batch)->residuals());
    std::copy(residuals.begin(), residuals.end(), out.begin());
  };
  CheckDerivative({given, value, Norm(linearization.residuals()), diagonal.view()}, [&](Index k, const Mismatch& at) {
    const std::string residual = problem_.NameResidual(batch, at.entry);
    if (k >= 0) {
      Add("the derivative of {} by {} is {:.6g} in J, by differences of the residuals {:.6g}", residual,
          problem_.NameTangent(k), at.given, at.difference);
    } else {
      Add("J v is {:.6g} at {} for some v, by differences of the residuals {:.6g}", at.given, residual, at.difference);
    }
  });
}

template <Backend B>
void ProblemChecker<B>::CheckGradient(ConstVectorView gradient, ConstVectorView diagonal) {
  const auto given = [&](ConstVectorView v) { return std::vector<double>{backend_.Dot(gradient, v)}; };
  const auto value = [&](ConstVectorView moved, std::span<double> out) { out[0] = problem_.VariableCost(moved); };
  CheckDerivative({given, value, std::sqrt(2 * cost_), diagonal}, [&](Index k, const Mismatch& at) {
    Add("the gradient {} is {:.6g}, by differences of Cost {:.6g}; make Gradient the derivative of Cost",
        k >= 0 ? "by " + problem_.NameTangent(k) : "along some v", at.given, at.difference);
  });
}

}  // namespace vesta::check_internal
