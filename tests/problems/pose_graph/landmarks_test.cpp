// SPDX-License-Identifier: Apache-2.0
// Solves of graphs with landmarks and priors.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "problems/pose_graph/certificate.h"
#include "problems/pose_graph/closure_check.h"
#include "problems/pose_graph/robust.h"
#include "problems/pose_graph/solve.h"
#include "tests/problems/pose_graph/ring_graph.h"
#include "tests/support/test_files.h"

namespace vesta::pose_graph {
namespace {

Eigen::Matrix2d Information(double xx, double xy, double yy) {
  Eigen::Matrix2d matrix;
  matrix << xx, xy, xy, yy;
  return matrix;
}

// Two fixed poses see a landmark: its position is the mean of the two measured ones, weighted by their information.
TEST(Landmarks, TwoMeasurementsAreAveragedByTheirInformation) {
  PoseGraph graph;
  graph.ids = {0, 1, 2};
  graph.poses = {0, 0, 0.3, 4, 1, -1.2, 7, 7, 0};
  graph.fixed = {0, 1};
  graph.landmarks = {2};
  graph.edges = {{0, 2}, {1, 2}};
  graph.measurements = {2, 1, 0, -1, 2, 0};
  graph.information = {4, 1, 0, 2, 0, 0, 1, -0.5, 0, 3, 0, 0};
  const Eigen::Matrix2d turn_a = Eigen::Rotation2Dd(0.3).toRotationMatrix(),
                        turn_b = Eigen::Rotation2Dd(-1.2).toRotationMatrix();
  const Eigen::Matrix2d of_a = turn_a * Information(4, 1, 2) * turn_a.transpose(),
                        of_b = turn_b * Information(1, -0.5, 3) * turn_b.transpose();
  const Eigen::Vector2d seen_by_a = turn_a * Eigen::Vector2d(2, 1),
                        seen_by_b = Eigen::Vector2d(4, 1) + turn_b * Eigen::Vector2d(-1, 2);
  const Eigen::Vector2d expected = (of_a + of_b).inverse() * (of_a * seen_by_a + of_b * seen_by_b);
  const PoseGraphSolution solution = SolvePoseGraph(graph);
  EXPECT_NEAR(solution.poses[6], expected[0], 1e-9);
  EXPECT_NEAR(solution.poses[7], expected[1], 1e-9);
  EXPECT_EQ(solution.poses[8], 0);
  const double cost = 0.5 * (seen_by_a - expected).dot(of_a * (seen_by_a - expected)) +
                      0.5 * (seen_by_b - expected).dot(of_b * (seen_by_b - expected));
  EXPECT_NEAR(solution.summary.final_cost, cost, 1e-9 * cost);
}

// Two priors of one pose.
TEST(Priors, AreAveragedByTheirInformation) {
  PoseGraph graph;
  graph.ids = {5, -1};
  graph.poses = {9, 9, 0.1, 0, 0, 0};
  graph.world = 1;
  graph.fixed = {1};
  graph.edges = {{1, 0}, {1, 0}};
  graph.measurements = {1, 2, 0.4, 3, 5, 0.4};
  graph.information = {2, 0, 0, 2, 0, 5, 6, 0, 0, 6, 0, 1};
  const PoseGraphSolution solution = SolvePoseGraph(graph);
  EXPECT_NEAR(solution.poses[0], (2 * 1 + 6 * 3) / 8.0, 1e-9);
  EXPECT_NEAR(solution.poses[1], (2 * 2 + 6 * 5) / 8.0, 1e-9);
  EXPECT_NEAR(solution.poses[2], 0.4, 1e-9);
}

template <class Space>
class GraphWithLandmarks : public testing::Test {};
using Spaces = testing::Types<Se2, Se3>;
TYPED_TEST_SUITE(GraphWithLandmarks, Spaces);

// Exact measurements, and starts without any knowledge of the poses.
TYPED_TEST(GraphWithLandmarks, TheChordalStartSolvesExactMeasurements) {
  PoseGraph graph = test::RingGraph<TypeParam>(20, 0, 3);
  test::AddLandmarksAndPriors<TypeParam>(graph, 4);
  const std::vector<double> truth = graph.poses;
  PoseGraph lost = graph;
  const auto size = static_cast<std::size_t>(TypeParam::kPose);
  for (std::size_t i = 0; i < 20; ++i) {
    for (std::size_t k = 0; k < size; ++k) lost.poses[i * size + k] = k == 3 ? 1 : 0;
  }
  const PoseGraphSolution solution = SolvePoseGraph(lost);
  EXPECT_TRUE(solution.starts_chordal);
  EXPECT_LE(solution.summary.final_cost, 1e-18);
  for (std::size_t k = 0; k < truth.size(); ++k) EXPECT_NEAR(std::abs(solution.poses[k]), std::abs(truth[k]), 1e-8);
}

// Two parts that share only landmarks: the rotations of the second follow from the positions of landmarks.
TYPED_TEST(GraphWithLandmarks, JoinTwoParts) {
  PoseGraph graph = test::RingGraph<TypeParam>(20, 0, 3);
  test::AddLandmarksAndPriors<TypeParam>(graph, 4);
  PoseGraph parts = graph;
  std::vector<bool> kept;
  for (const auto& [from, to] : graph.edges) {
    kept.push_back(from == graph.world ? to == 0 : graph.IsLandmark(to) || (from < 10) == (to < 10));
  }
  parts = WithEdges(graph, kept);
  PoseGraphSolveOptions options;
  options.initialize = Initialize::kChordal;
  const PoseGraphSolution solution = SolvePoseGraph(parts, options);
  EXPECT_LE(solution.summary.final_cost, 1e-16);
}

TEST(PriorsOnly, HoldAGraphForACertificate) {
  PoseGraph graph = test::RingGraph<Se2>(20, 0.02, 3);
  PoseGraph with_landmarks = graph;
  test::AddLandmarksAndPriors<Se2>(with_landmarks, 4);
  EXPECT_THAT([&] { Certify(with_landmarks, with_landmarks.poses); }, ThrowsError(kUnsupported));
  EXPECT_THAT([&] { SolveRobustPoseGraph(with_landmarks); }, ThrowsError(kUnsupported));
  graph.world = graph.num_poses();
  graph.ids.push_back(-1);
  graph.poses.insert(graph.poses.end(), 3, 0.0);
  graph.fixed = {graph.world};
  test::AddEdge(graph, graph.world, 0, {10, 0, 0});
  PoseGraphSolveOptions options;
  options.problem.error = EdgeError::kIsotropic;
  options.lm.function_tolerance = 1e-14;
  const PoseGraphSolution solution = SolvePoseGraph(graph, options);
  EXPECT_TRUE(Certify(graph, solution.poses).is_optimal());
}

TEST(Landmarks, GraphsThatDoNotFitAreRefused) {
  PoseGraph graph = test::RingGraph<Se3>(20, 0, 3);
  test::AddLandmarksAndPriors<Se3>(graph, 4);
  const auto refused = [&](const auto& change, ErrorCode code = kBadArgument) {
    PoseGraph changed = graph;
    change(changed);
    EXPECT_THAT([&] { PoseGraphProblem problem(changed); }, ThrowsError(code));
  };
  refused([](PoseGraph& g) { g.landmarks.push_back(g.num_poses()); });
  refused([](PoseGraph& g) { g.poses[static_cast<std::size_t>(g.landmarks[1] * 7 + 4)] = 0.1; });
  refused([](PoseGraph& g) { std::swap(g.edges[g.edges.size() - 3].from, g.edges[g.edges.size() - 3].to); });
  refused([](PoseGraph& g) { g.information[g.information.size() - 2 * 21 - 1] = 1; });
  refused([](PoseGraph& g) { g.edges[g.edges.size() - 3].from = g.world; }, kUnsupported);
}

}  // namespace
}  // namespace vesta::pose_graph
