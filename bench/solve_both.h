// The same functors solved by vesta and by Ceres.
#pragma once

#include <ceres/ceres.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "solver/bounds.h"
#include "solver/ceres/to_ceres.h"
#include "solver/levenberg_marquardt.h"

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
inline LmOptions ExactOptions(int num_parameters) {
  LmOptions options;
  options.max_iterations = 10000;
  options.function_tolerance = 0;
  options.gradient_tolerance = 0;
  options.parameter_tolerance = 1e-16;
  options.column_scaling = ColumnScaling::kOnePlusInverse;
  options.normal_system.pcg = {
      .max_iterations = 20 * num_parameters, .relative_tolerance = 1e-16, .model_tolerance = 0};
  return options;
}

// One lower and one upper bound for each parameter; empty: none.
struct Box {
  std::span<const double> lower, upper;
};

// loss and loss_ceres: the same loss for both, or null. A start outside the box is moved onto it.
template <class F>
BothResults SolveBoth(const std::vector<F>& functors, std::span<const double> start,
                      std::shared_ptr<const Loss> loss = nullptr, ceres::LossFunction* loss_ceres = nullptr,
                      const Box& box = {}) {
  using B = CpuBackend<double>;
  BothResults results;
  const auto n = static_cast<Index>(start.size());
  ResidualBlocks<F, B> blocks(n, functors, {}, {.loss = std::move(loss)});
  std::optional<BoundedProblem<B>> bounded;
  B backend;
  B::Vector x(n);
  std::copy(start.begin(), start.end(), x.begin());
  if (!box.lower.empty()) {
    bounded.emplace(blocks, std::vector(box.lower.begin(), box.lower.end()),
                    std::vector(box.upper.begin(), box.upper.end()));
    for (std::size_t k = 0; k < start.size(); ++k) {
      x[static_cast<Index>(k)] = std::clamp(start[k], box.lower[k], box.upper[k]);
    }
  }
  Problem<B>& problem = bounded ? static_cast<Problem<B>&>(*bounded) : blocks;
  results.x_ceres.assign(x.begin(), x.end());
  results.start_cost = problem.Cost(x);
  results.summary = SolveLm(ExactOptions(F::kParameters), backend, problem, x.view());
  results.cost = results.summary.final_cost;
  results.x.assign(x.begin(), x.end());

  ceres::Problem ceres_problem;
  for (const F& functor : functors) {
    ceres_problem.AddResidualBlock(ToCeres(functor), loss_ceres, results.x_ceres.data());
  }
  for (int k = 0; k < static_cast<int>(box.lower.size()); ++k) {
    ceres_problem.SetParameterLowerBound(results.x_ceres.data(), k, box.lower[static_cast<std::size_t>(k)]);
    ceres_problem.SetParameterUpperBound(results.x_ceres.data(), k, box.upper[static_cast<std::size_t>(k)]);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 10000;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-30;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  results.cost_ceres = summary.final_cost;
  results.iterations_ceres = static_cast<int>(summary.iterations.size()) - 1;
  return results;
}

}  // namespace vesta
