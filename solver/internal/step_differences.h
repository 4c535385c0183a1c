// SPDX-License-Identifier: Apache-2.0
// Derivatives by differences, with a judgement of their own error: what others are compared with.
#pragma once

#include <functional>
#include <span>
#include <vector>

namespace vesta {

struct StepDifferences {
  std::vector<double> value;
  // A difference beyond some times this is none of rounding or of the length of the step. Infinite where f was not
  // finite.
  std::vector<double> error;
};

// d f / d t at t = 0, f(t, out) writing `size` numbers of relative rounding epsilon, at a place that is rounded by
// epsilon * place in units of t: central differences over steps
// +-t that begin at `largest` and fall by 4, extrapolated to 0 (Ridders, Accurate computation of F'(x) and F'(x)F''(x),
// 1982), for each number with the steps that agree best.
StepDifferences DifferenceAlong(const std::function<void(double t, std::span<double> out)>& f, std::size_t size,
                                double largest, double epsilon, double place);

}  // namespace vesta
