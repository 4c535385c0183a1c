// SPDX-License-Identifier: Apache-2.0
// Nonmonotonic steps beside Ceres.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/archive.h"
#include "tests/solver/ceres/twin_problem.h"

namespace vesta::test {
namespace {

// Rosenbrock's function: a curved valley.
struct CurvedValley {
  template <class T>
  bool operator()(const T* p, T* r) const {
    r[0] = T(100.0) * (p[1] - p[0] * p[0]);
    r[1] = T(1.0) - p[0];
    return true;
  }
};

struct TwinValley : TwinProblem {
  TwinValley() {
    const int block = AddBlock({-1.2, 1});
    Add<2, 2>(CurvedValley(), {block});
  }
};

// Ends by the gradient, because Ceres does not record a step that is too short.
ceres::Solver::Options Nonmonotonic(int steps) {
  ceres::Solver::Options options = Quiet();
  options.function_tolerance = options.parameter_tolerance = 0;
  options.max_num_iterations = 500;
  options.use_nonmonotonic_steps = steps > 0;
  if (steps > 0) options.max_consecutive_nonmonotonic_steps = steps;
  return options;
}

TEST(CeresCasesNonmonotonic, SameStepsAsCeres) {
  std::size_t monotonic = 0;
  for (const int steps : {0, 1, 3, 5}) {
    SCOPED_TRACE(steps);
    TwinValley valley;
    const Solved expected = valley.Solve(Way::kCeres, Nonmonotonic(steps));
    for (const Way way : {Way::kBridge, Way::kNative}) {
      const Solved solved = valley.Solve(way, Nonmonotonic(steps));
      EXPECT_TRUE(solved.converged) << solved.report;
      EXPECT_EQ(solved.num_iterations, expected.num_iterations) << solved.report;
      EXPECT_NEAR(solved.final_cost, expected.final_cost, 1e-12);
    }
    if (steps == 0) monotonic = expected.num_iterations;
    if (steps == 5) {
      EXPECT_LT(expected.num_iterations, monotonic);
    }
  }
}

// x is the point with the lowest cost, at whatever iteration the solve ends.
TEST(CeresCasesNonmonotonic, ReturnsTheBestPoint) {
  int rises = 0;
  for (int iterations = 1; iterations < 12; ++iterations) {
    TwinValley valley;
    LmOptions options = ceres_bridge::FromCeres(Nonmonotonic(5));
    options.max_iterations = iterations;
    std::vector<double> x = valley.x();
    const LmSummary summary = SolveLm(valley.ours(), x, options);
    double lowest = std::numeric_limits<double>::infinity();
    for (const LmIteration& row : summary.iterations) lowest = std::min(lowest, row.cost);
    EXPECT_EQ(summary.final_cost, lowest);
    EXPECT_EQ(valley.ours().Cost(View(x)), lowest);
    rises += summary.iterations.back().cost > lowest;
  }
  EXPECT_GT(rises, 0);
}

TEST(CeresCasesNonmonotonic, ResumesWithTheSameBits) {
  using B = CpuBackend<double>;
  TwinValley valley;
  const LmOptions options = ceres_bridge::FromCeres(Nonmonotonic(5));
  const std::vector<double> x = valley.x();
  B backend;
  LmStepper<B> whole(options, backend, valley.ours(), View(x));
  while (!whole.done()) whole.Step();
  for (int iterations = 1; iterations < 8; ++iterations) {
    LmStepper<B> first(options, backend, valley.ours(), View(x));
    for (int k = 0; k < iterations; ++k) first.Step();
    std::string bytes;
    ArchiveWriter writer([&](std::string_view piece) { bytes.append(piece); });
    first.Save(writer);
    ArchiveReader reader(bytes);
    LmStepper<B> second(options, backend, valley.ours(), reader);
    while (!second.done()) second.Step();
    EXPECT_EQ(second.summary().iterations.size(), whole.summary().iterations.size());
    EXPECT_EQ(second.cost(), whole.cost());
  }
}

}  // namespace
}  // namespace vesta::test
