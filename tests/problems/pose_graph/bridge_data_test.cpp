// SPDX-License-Identifier: Apache-2.0
// Graphs of the field through the bridge, as cost functions that vesta knows nothing of, beside Ceres itself.
#include <gtest/gtest.h>

#include "bench/solver_race/ceres_pose_graph.h"
#include "kernels/core/files.h"
#include "problems/pose_graph/g2o_file.h"
#include "solver/ceres/ceres_problem.h"
#include "tests/support/test_files.h"

namespace vesta::pose_graph {
namespace {

class BridgeData : public testing::TestWithParam<const char*> {};

TEST_P(BridgeData, ReachesTheCostOfCeresSparseCholesky) {
  const std::string path = DataFolder() + "/nlls/g2o/" + GetParam() + ".g2o";
  if (!FileExists(path)) GTEST_SKIP() << "no " << path << ": set VESTA_DATA to a folder with nlls/g2o";
  const PoseGraph graph = ReadG2o(path);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 100;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-14;
  options.num_threads = 2;
  options.logging_type = ceres::SILENT;
  const auto build = [&](std::vector<double>& poses, ceres::Problem& problem) {
    poses = graph.poses;
    bench::BuildCeresPoseGraph(graph, Whitening::kLower, nullptr, poses, problem);
  };
  std::vector<double> poses;
  ceres::Problem theirs;
  build(poses, theirs);
  ceres::Solver::Summary expected;
  ceres::Solve(options, &theirs, &expected);

  // By options of its own, which find the factor by themselves, and by those of Ceres.
  LmOptions own;
  own.max_iterations = 100;
  own.function_tolerance = own.gradient_tolerance = own.parameter_tolerance = 1e-14;
  for (const LmOptions& lm : {own, ceres_bridge::FromCeres(options)}) {
    ceres::Problem ours;
    build(poses, ours);
    const LmSummary summary = ceres_bridge::Solve(lm, ours);
    EXPECT_LE(summary.final_cost, (1 + 1e-9) * expected.final_cost) << summary.FullReport();
    EXPECT_NE(summary.linear_solver.find("PCG, sparse Cholesky"), std::string::npos) << summary.linear_solver;
  }
}

INSTANTIATE_TEST_SUITE_P(Graphs, BridgeData, testing::Values("input_M3500_g2o", "intel", "sphere2500"),
                         [](const auto& tested) { return std::string(tested.param); });

}  // namespace
}  // namespace vesta::pose_graph
