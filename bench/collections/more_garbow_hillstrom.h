// SPDX-License-Identifier: Apache-2.0
// The problems of more_garbow_hillstrom_models.h as SmallProblem, in a table.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench/collections/solve_both.h"

namespace vesta::mgh {

struct Formula {
  int number;  // in the paper
  std::string name;
  SmallProblem problem;
  std::span<const double> start;
  double sum_of_squares;               // sum of squared residuals at the known minimum: twice vesta's cost
  std::span<const double> stationary;  // the same at further minima that the paper lists
  Box box;                             // bounds; empty: none
  double bounded_sum_of_squares;       // the same at the known minimum within the bounds

  bool bounded() const { return !box.lower.empty(); }
};

// All problems, in the order of ForEachProblem.
const std::vector<Formula>& Formulas();

}  // namespace vesta::mgh
