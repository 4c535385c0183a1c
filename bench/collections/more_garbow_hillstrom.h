// SPDX-License-Identifier: Apache-2.0
// more_garbow_hillstrom_models.h as a table of SmallProblem.
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
  double sum_of_squares;               // at the known minimum: twice vesta's cost
  std::span<const double> stationary;  // the same at further minima in the paper
  Box box;                             // bounds; empty: none
  double bounded_sum_of_squares;       // the same within the bounds

  bool bounded() const { return !box.lower.empty(); }
};

// All problems, in the order of ForEachProblem.
const std::vector<Formula>& Formulas();

}  // namespace vesta::mgh
