// SPDX-License-Identifier: Apache-2.0
// Solves a small problem with vesta and with Ceres.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "bench/collections/small_problem.h"
#include "solver/lm_options.h"
#include "solver/summary.h"

namespace vesta {

struct BothResults {
  std::vector<double> x, x_ceres;  // solutions of vesta and Ceres
  double start_cost = 0, cost = 0, cost_ceres = 0;
  LmSummary summary;
  int iterations_ceres = 0;

  // vesta's cost is at most 1.00000001 times Ceres's cost, plus 1e-14 times the starting cost.
  bool SameMinimum() const { return cost <= cost_ceres + 1e-8 * cost_ceres + 1e-14 * start_cost; }
};

// Options for small problems, to the last digit: PCG iterates until only rounding errors remain.
LmOptions ExactOptions(int num_parameters);

// Bounds of each parameter; empty: none.
struct Box {
  std::span<const double> lower, upper;
};

// loss, loss_ceres: the same robust loss for vesta and for Ceres, which takes ownership; or both null. A start outside
// the box is moved to its border.
BothResults SolveBoth(const SmallProblem& problem, std::span<const double> start,
                      std::shared_ptr<const Loss> loss = nullptr, ceres::LossFunction* loss_ceres = nullptr,
                      const Box& box = {});

}  // namespace vesta
