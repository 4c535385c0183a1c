// SPDX-License-Identifier: Apache-2.0
// Derivatives by finite differences, with an estimate of their own error. They check other derivatives.
#pragma once

#include <functional>
#include <span>
#include <vector>

namespace vesta {

struct StepDifferences {
  std::vector<double> value;
  // Estimated error from rounding and from the step length. A difference of several times this is significant. Infinite
  // if f was not finite.
  std::vector<double> error;
};

// Estimates d f / d t at t = 0. f(t, out) writes `size` numbers with relative rounding error epsilon, at a point whose
// own rounding error is epsilon * place in units of t. Uses central differences with steps +-t that begin at `largest`
// and shrink by 4, extrapolated to 0 (Ridders, Accurate computation of F'(x) and F'(x)F''(x), 1982). For each number it
// returns the estimate with the smallest error.
StepDifferences DifferenceAlong(const std::function<void(double t, std::span<double> out)>& f, std::size_t size,
                                double largest, double epsilon, double place);

}  // namespace vesta
