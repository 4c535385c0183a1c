// SPDX-License-Identifier: Apache-2.0
// The same functors solved by vesta and by Ceres.
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

  // |c - c_Ceres| <= 1e-8 c_Ceres + 1e-14 c_start, or lower.
  bool SameMinimum() const { return cost <= cost_ceres + 1e-8 * cost_ceres + 1e-14 * start_cost; }
};

// Options for small problems solved to the last digit: PCG runs until its residual is rounding.
LmOptions ExactOptions(int num_parameters);

// One lower and one upper bound for each parameter; empty: none.
struct Box {
  std::span<const double> lower, upper;
};

// loss and loss_ceres: the same loss for both, or null. A start outside the box is moved onto it.
BothResults SolveBoth(const SmallProblem& problem, std::span<const double> start,
                      std::shared_ptr<const Loss> loss = nullptr, ceres::LossFunction* loss_ceres = nullptr,
                      const Box& box = {});

}  // namespace vesta
