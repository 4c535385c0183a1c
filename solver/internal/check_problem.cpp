// SPDX-License-Identifier: Apache-2.0
#include "solver/check_problem.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "solver/internal/step_differences.h"

namespace vesta {

std::string ProblemCheck::Report() const {
  return ok() ? "no fault was found" : fmt::format("{}", fmt::join(faults, "\n"));
}

StepDifferences DifferenceAlong(const std::function<void(double t, std::span<double> out)>& f, std::size_t size,
                                double largest, double epsilon, double place) {
  constexpr int kSteps = 12;
  StepDifferences best{std::vector<double>(size, 0.0),
                       std::vector<double>(size, std::numeric_limits<double>::infinity())};
  std::vector<double> at(size), above(size), below(size), slope(size), extrapolated(size), last_slope(size),
      last_extrapolated(size);
  f(0, at);
  double t = largest;
  for (int step = 0; step < kSteps; ++step, t /= 4) {
    f(t, above);
    f(-t, below);
    for (std::size_t i = 0; i < size; ++i) {
      slope[i] = (above[i] - below[i]) / (2 * t);
      // A central difference has an error of order t^2.
      extrapolated[i] = slope[i] + (slope[i] - last_slope[i]) / 15;
      if (step < 2) continue;
      const double bend = std::abs(above[i] - at[i]) + std::abs(below[i] - at[i]);
      const double rounding = epsilon * (std::max(std::abs(above[i]), std::abs(below[i])) + place * bend / t) / t;
      const double error = std::abs(extrapolated[i] - last_extrapolated[i]) + rounding;
      if (error < best.error[i]) best.value[i] = extrapolated[i], best.error[i] = error;
    }
    std::swap(slope, last_slope);
    std::swap(extrapolated, last_extrapolated);
  }
  return best;
}

}  // namespace vesta
