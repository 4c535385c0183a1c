// SPDX-License-Identifier: Apache-2.0
// Derivatives by extrapolated finite differences, with an estimate of their error. Used by CheckProblem, and by
// NumericDifferences with DifferenceMethod::kRidders.
#pragma once

#include <functional>
#include <span>
#include <vector>

namespace vesta {

struct StepDifferences {
  std::vector<double> value;  // derivatives
  // Estimated error of each derivative, due to rounding and to the step length; infinity if f was not finite.
  std::vector<double> error;
};

// Estimates df/dt at t = 0, where f(t, out) writes `size` numbers. epsilon: relative rounding error of these numbers.
// Rounding may also change t itself, by epsilon * place. Uses central differences with steps +-t. t begins at `largest`
// and is divided by 4 up to 11 times, and the differences are extrapolated to t = 0 (Ridders, Accurate computation of
// F'(x) and F'(x)F''(x), 1982). For each number, returns the estimate with the smallest error. Ends as soon as rounding
// alone exceeds the errors of these estimates.
StepDifferences DifferenceAlong(const std::function<void(double t, std::span<double> out)>& f, std::size_t size,
                                double largest, double epsilon, double place);

}  // namespace vesta
