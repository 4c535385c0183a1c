// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/step_differences.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace vesta {

StepDifferences DifferenceAlong(const std::function<void(double t, std::span<double> out)>& f, std::size_t size,
                                double largest, double epsilon, double place) {
  constexpr int kSteps = 12;
  // Row of Neville's tableau: the central difference, with an error of order t^2, and extrapolations of order t^4, t^6,
  // and so on.
  using Row = std::array<double, 5>;
  StepDifferences best{std::vector<double>(size, 0.0),
                       std::vector<double>(size, std::numeric_limits<double>::infinity())};
  std::vector<double> at(size), above(size), below(size);
  std::vector<Row> rows(size), last_rows(size);
  f(0, at);
  double t = largest;
  // Ends when rounding alone exceeds each error.
  bool can_improve = true;
  for (int step = 0; step < kSteps && can_improve; ++step, t /= 4) {
    f(t, above);
    f(-t, below);
    std::swap(rows, last_rows);
    can_improve = step < 2;
    for (std::size_t i = 0; i < size; ++i) {
      Row& row = rows[i];
      const Row& last = last_rows[i];
      const double bend = std::abs(above[i] - at[i]) + std::abs(below[i] - at[i]);
      const double rounding = epsilon * (std::max(std::abs(above[i]), std::abs(below[i])) + place * bend / t) / t;
      row[0] = (above[i] - below[i]) / (2 * t);
      double weight = 1;
      for (std::size_t k = 1; k < row.size() && k <= static_cast<std::size_t>(step); ++k) {
        weight *= 16;  // (ratio of the steps)^2k
        row[k] = row[k - 1] + (row[k - 1] - last[k - 1]) / (weight - 1);
        const double error = std::max(std::abs(row[k] - row[k - 1]), std::abs(row[k] - last[k - 1])) + rounding;
        if (step >= 2 && error < best.error[i]) best.value[i] = row[k], best.error[i] = error;
      }
      can_improve = can_improve || !(rounding >= best.error[i]);
    }
  }
  return best;
}

}  // namespace vesta
