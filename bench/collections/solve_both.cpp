// SPDX-License-Identifier: Apache-2.0
#include "bench/collections/solve_both.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "solver/bounds.h"
#include "solver/levenberg_marquardt.h"

namespace vesta {
namespace {

using B = SmallProblem::B;

void SolveByVesta(Problem<B>& unbounded, const Box& box, BothResults& results) {
  std::optional<BoundedProblem<B>> bounded;
  if (!box.lower.empty()) {
    bounded.emplace(unbounded, std::vector(box.lower.begin(), box.lower.end()),
                    std::vector(box.upper.begin(), box.upper.end()));
  }
  Problem<B>& problem = bounded ? static_cast<Problem<B>&>(*bounded) : unbounded;
  B backend;
  B::Vector x(static_cast<Index>(results.x.size()));
  std::copy(results.x.begin(), results.x.end(), x.begin());
  results.start_cost = problem.Cost(x);
  results.summary = SolveLm(ExactOptions(static_cast<int>(x.size())), backend, problem, x.view());
  results.cost = results.summary.final_cost;
  results.x.assign(x.begin(), x.end());
}

void SolveByCeres(const SmallProblem& problem, ceres::LossFunction* loss, const Box& box, BothResults& results) {
  ceres::Problem ceres_problem;
  double* x = results.x_ceres.data();
  problem.add_to(ceres_problem, loss, x);
  for (int k = 0; k < static_cast<int>(box.lower.size()); ++k) {
    ceres_problem.SetParameterLowerBound(x, k, box.lower[static_cast<std::size_t>(k)]);
    ceres_problem.SetParameterUpperBound(x, k, box.upper[static_cast<std::size_t>(k)]);
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
}

}  // namespace

LmOptions ExactOptions(int num_parameters) {
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

BothResults SolveBoth(const SmallProblem& problem, std::span<const double> start, std::shared_ptr<const Loss> loss,
                      ceres::LossFunction* loss_ceres, const Box& box) {
  BothResults results;
  results.x.assign(start.begin(), start.end());
  for (std::size_t k = 0; k < box.lower.size(); ++k) {
    results.x[k] = std::clamp(results.x[k], box.lower[k], box.upper[k]);
  }
  results.x_ceres = results.x;
  SolveByVesta(*problem.make(std::move(loss)), box, results);
  SolveByCeres(problem, loss_ceres, box, results);
  return results;
}

}  // namespace vesta
