// SPDX-License-Identifier: Apache-2.0
// vesta and Ceres reach the same minima of pose graphs.
#include <gtest/gtest.h>

#include "bench/solver_race/ceres_pose_graph.h"
#include "solver/levenberg_marquardt.h"
#include "tests/problems/pose_graph/ring_graph.h"

namespace vesta::pose_graph {
namespace {

using B = CpuBackend<double>;

LmOptions ExactOptions() {
  LmOptions options = PoseGraphOptions();
  options.max_iterations = 500;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-16;
  return options;
}

// vesta's cost is at most 1e-8 (relative) above Ceres's.
void ExpectSameMinimum(const PoseGraph& graph, std::shared_ptr<const Loss> loss, ceres::LossFunction* ceres_loss) {
  PoseGraphProblem problem(graph, {.error = EdgeError::kCeres, .loss = std::move(loss)});
  B backend;
  B::Vector x = test::Start(problem);
  const double start_cost = problem.Cost(x);
  const LmSummary summary = SolveLm(ExactOptions(), backend, problem, x.view());
  std::vector<double> poses;
  const double expected = bench::CeresPoseGraphCost(graph, ceres_loss, &poses);
  EXPECT_LE(summary.final_cost, expected + 1e-8 * expected + 1e-14 * start_cost) << summary.FullReport();
  EXPECT_LT(summary.final_cost, 0.9 * start_cost);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double difference = x[static_cast<Index>(i)] - poses[i];
    const bool is_yaw = graph.space == PoseSpace::kSe2 && i % 3 == 2;
    EXPECT_NEAR(is_yaw ? Se2::NormalizeAngle(difference) : difference, 0, 1e-5) << i;
  }
}

TEST(PoseGraphSolve, RingInThePlane) { ExpectSameMinimum(test::RingGraph<Se2>(60, 0.1, 1), nullptr, nullptr); }
TEST(PoseGraphSolve, RingInSpace) { ExpectSameMinimum(test::RingGraph<Se3>(60, 0.1, 2), nullptr, nullptr); }
TEST(PoseGraphSolve, RobustLoss) {
  ExpectSameMinimum(test::RingGraph<Se3>(40, 0.1, 3), std::make_shared<HuberLoss>(0.5), new ceres::HuberLoss(0.5));
}

TEST(PoseGraphSolve, WithoutNoiseTheResidualVanishes) {
  PoseGraph graph = test::RingGraph<Se3>(30, 0, 4);
  test::Random random(5);
  for (Index i = 1; i < graph.num_poses(); ++i) {
    std::vector<double> step = random.NormalVector<double>(6), moved(7);
    for (double& s : step) s *= 0.1;
    Se3::Plus(graph.poses.data() + 7 * i, step.data(), moved.data());
    std::copy(moved.begin(), moved.end(), graph.poses.begin() + 7 * i);
  }
  PoseGraphProblem problem(graph);
  B backend;
  B::Vector x = test::Start(problem);
  const LmSummary summary = SolveLm(ExactOptions(), backend, problem, x.view());
  EXPECT_LE(summary.final_cost, 1e-20 * summary.initial_cost) << summary.FullReport();
}

TEST(PoseGraphSolve, TheCholeskyFactorIsAnExactPreconditioner) {
  PoseGraphProblem problem(test::RingGraph<Se3>(200, 0.1, 6));
  B backend;
  const auto iterations = [&](PreconditionerKind kind) {
    B::Vector x = test::Start(problem);
    LmOptions options = PoseGraphOptions();
    options.max_iterations = 3;
    options.normal_system.preconditioner = kind;
    options.normal_system.pcg.max_iterations = 5000;
    options.normal_system.pcg.model_tolerance = 0;
    const LmSummary summary = SolveLm(options, backend, problem, x.view());
    return summary.num_pcg_iterations;
  };
  EXPECT_LE(iterations(PreconditionerKind::kProblem), 2 * 3);
  EXPECT_GE(iterations(PreconditionerKind::kBlockJacobi), 50 * 3);
}

TEST(PoseGraphSolve, WithoutMemoryForAFactorTheDiagonalBlocksDo) {
  const PoseGraph graph = test::RingGraph<Se3>(40, 0.1, 7);
  const auto cost = [&](double max_factor_gib, int* pcg_iterations) {
    PoseGraphProblem problem(graph, {.max_factor_gib = max_factor_gib});
    B backend;
    B::Vector x = test::Start(problem);
    const LmSummary summary = SolveLm(ExactOptions(), backend, problem, x.view());
    *pcg_iterations = summary.num_pcg_iterations / summary.num_accepted;
    return summary.final_cost;
  };
  int exact = 0, blocks = 0;
  const double expected = cost(1, &exact);
  EXPECT_NEAR(cost(1e-9, &blocks), expected, 1e-8 * expected);
  EXPECT_LE(exact, 2);
  EXPECT_GE(blocks, 10);
}

}  // namespace
}  // namespace vesta::pose_graph
