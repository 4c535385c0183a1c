// SPDX-License-Identifier: Apache-2.0
// The problems of More, Garbow and Hillstrom (bench/collections/more_garbow_hillstrom_models.h) as problems.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench/collections/solve_both.h"

namespace vesta::mgh {

struct Formula {
  int number;
  std::string name;
  SmallProblem problem;
  std::span<const double> start;
  double sum_of_squares;               // twice our cost at the known minimum
  std::span<const double> stationary;  // those of further minima that the paper lists
  Box box;                             // empty: none
  double bounded_sum_of_squares;       // at the known minimum within the box

  bool bounded() const { return !box.lower.empty(); }
};

// All, in the order of ForEachProblem.
const std::vector<Formula>& Formulas();

}  // namespace vesta::mgh
