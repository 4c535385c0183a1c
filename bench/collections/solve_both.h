// SPDX-License-Identifier: Apache-2.0
// Solves the same small problem with vesta and with Ceres.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "bench/collections/small_problem.h"
#include "solver/lm_options.h"
#include "solver/summary.h"

namespace vesta {

struct BothResults {
  std::vector<double> x, x_ceres;
  double start_cost = 0, cost = 0, cost_ceres = 0;
  LmSummary summary;
  int iterations_ceres = 0;

  // True if vesta's cost is at most Ceres's, plus 1e-8 of it and 1e-14 of the starting cost.
  bool SameMinimum() const { return cost <= cost_ceres + 1e-8 * cost_ceres + 1e-14 * start_cost; }
};

// Options to solve small problems to the last digit: PCG runs until its residual is a rounding error.
LmOptions ExactOptions(int num_parameters);

// Lower and upper bounds of all parameters; empty: no bounds.
struct Box {
  std::span<const double> lower, upper;
};

// loss and loss_ceres: the same loss for each engine, or null for both. A start outside the box is clamped to it.
BothResults SolveBoth(const SmallProblem& problem, std::span<const double> start,
                      std::shared_ptr<const Loss> loss = nullptr, ceres::LossFunction* loss_ceres = nullptr,
                      const Box& box = {});

}  // namespace vesta
