// SPDX-License-Identifier: Apache-2.0
// A program that solves a ceres::Problem with vesta. The marked lines, and the type of the callback `print`, differ
// from a program that calls ceres::Solve.
#include <ceres/ceres.h>

#include <cmath>
#include <cstdio>

#include "solver/ceres/ceres_solve.h"  // changed

struct Line {
  double t, y;
  template <class T>
  bool operator()(const T* slope, const T* height, T* residual) const {
    residual[0] = slope[0] * t + height[0] - y;
    return true;
  }
};

int main() {
  double slope = 0, height = 0;
  ceres::Problem problem;
  for (int i = 0; i < 50; ++i) {
    const double y = 2.0 * i - 5 + (i % 10 == 7 ? 40.0 : 0.0);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Line, 1, 1, 1>(new Line{1.0 * i, y}),
                             new ceres::CauchyLoss(0.1), &slope, &height);
  }
  problem.SetParameterLowerBound(&slope, 0, 0);

  ceres::Solver::Options options;
  options.max_num_iterations = 100;
  const auto print = [](const vesta::LmIteration& row) {
    std::printf("%3d  cost %.6e\n", row.iteration, row.cost);
    return vesta::CallbackResult::kContinue;
  };
  const vesta::LmSummary summary = vesta::ceres_bridge::Solve(options, problem, print);  // changed
  std::puts(summary.BriefReport().c_str());

  std::printf("slope %.4f, height %.4f\n", slope, height);
  const bool found = std::abs(slope - 2) < 0.01 && std::abs(height + 5) < 0.1;
  return vesta::IsConverged(summary.status) && found ? 0 : 1;  // changed
}
