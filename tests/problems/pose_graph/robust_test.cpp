// SPDX-License-Identifier: Apache-2.0
// Wrong loop closures are found and rejected.
#include "problems/pose_graph/robust.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "problems/pose_graph/closure_check.h"
#include "tests/problems/pose_graph/ring_graph.h"

namespace vesta::pose_graph {
namespace {

// From printed tables of the chi-square distribution.
TEST(ChiSquareQuantile, HasTheValuesOfTables) {
  EXPECT_NEAR(ChiSquareQuantile(1, 0.05), 3.841, 5e-4);
  EXPECT_NEAR(ChiSquareQuantile(2, 0.01), 9.210, 5e-4);
  EXPECT_NEAR(ChiSquareQuantile(3, 0.01), 11.345, 5e-4);
  EXPECT_NEAR(ChiSquareQuantile(6, 0.95), 1.635, 5e-4);
  EXPECT_NEAR(ChiSquareQuantile(6, 0.001), 22.458, 5e-4);
  EXPECT_THROW(ChiSquareQuantile(0, 0.5), Error);
  EXPECT_THROW(ChiSquareQuantile(3, 0), Error);
  EXPECT_THROW(ChiSquareQuantile(3, 1), Error);
}

template <class Space>
class RobustPoseGraph : public testing::Test {
 protected:
  // Joins random pairs of poses with random measurements.
  static PoseGraph WithWrongClosures(PoseGraph graph, int count, std::uint64_t seed) {
    test::Random random(seed);
    for (int k = 0; k < count; ++k) {
      const std::vector<double> turn = random.NormalVector<double>(Space::kTangent);
      std::vector<double> none(Space::kPose), measurement(Space::kPose);
      if (Space::kPose == 7) none[3] = 1;
      Space::Plus(none.data(), turn.data(), measurement.data());
      for (int i = 0; i < Space::kTangent / 3 + 1; ++i) measurement[static_cast<std::size_t>(i)] *= 8;
      if (Space::kPose == 3) measurement[2] = Se2::NormalizeAngle(3 * turn[2]);
      const Index from = 3 * k + 1;
      test::AddEdge(graph, from, (from + 7 + 5 * k) % graph.num_poses(), measurement);
    }
    return graph;
  }
};
using Spaces = testing::Types<Se2, Se3>;
TYPED_TEST_SUITE(RobustPoseGraph, Spaces);

TYPED_TEST(RobustPoseGraph, RejectsTheWrongClosuresAlone) {
  const PoseGraph clean = test::RingGraph<TypeParam>(60, 0.01, 1, 1);
  const PoseGraphSolution expected = SolvePoseGraph(clean);
  const PoseGraph graph = this->WithWrongClosures(clean, 6, 2);
  const RobustSolution robust = SolveRobustPoseGraph(graph);
  for (Index e = 0; e < graph.num_edges(); ++e) {
    EXPECT_EQ(robust.kept[static_cast<std::size_t>(e)], e < clean.num_edges()) << e;
  }
  EXPECT_EQ(robust.num_rejected, 6);
  for (std::size_t i = 0; i < expected.poses.size(); ++i) {
    EXPECT_NEAR(robust.solution.poses[i], expected.poses[i], 1e-4) << i;
  }
  // Without the rejection, the wrong closures move the poses.
  const PoseGraphSolution plain = SolvePoseGraph(graph);
  double largest = 0;
  for (std::size_t i = 0; i < expected.poses.size(); ++i) {
    largest = std::max(largest, std::abs(plain.poses[i] - expected.poses[i]));
  }
  EXPECT_GT(largest, 1);
}

TYPED_TEST(RobustPoseGraph, LargeInformationIsScaled) {
  const PoseGraph graph = this->WithWrongClosures(test::RingGraph<TypeParam>(60, 0.01, 1, 1), 6, 2);
  PoseGraph scaled = graph;
  for (double& value : scaled.information) value *= 1e6;
  const ClosureCheck check = CheckClosures(graph), of_scaled = CheckClosures(scaled);
  EXPECT_EQ(check.supported, of_scaled.supported);
  EXPECT_NEAR(of_scaled.rotation_scale, 1e6 * check.rotation_scale, 1e-6 * of_scaled.rotation_scale);
  EXPECT_NEAR(of_scaled.position_scale, 1e6 * check.position_scale, 1e-6 * of_scaled.position_scale);
  const RobustSolution robust = SolveRobustPoseGraph(scaled);
  for (Index e = graph.num_edges() - 6; e < graph.num_edges(); ++e) {
    EXPECT_FALSE(robust.kept[static_cast<std::size_t>(e)]) << e;
  }
  // The noise of the true closures does not follow their random information, so one more may be rejected.
  EXPECT_LE(robust.num_rejected, 7);
  EXPECT_GT(robust.information_scale, 1);
}

TYPED_TEST(RobustPoseGraph, WithoutClosuresIsThePlainSolve) {
  const PoseGraph graph = test::RingGraph<TypeParam>(20, 0.01, 1, 1);
  std::vector<bool> odometry;
  for (Index e = 0; e < graph.num_edges(); ++e) odometry.push_back(IsOdometry(graph, e));
  const PoseGraph chain = WithEdges(graph, odometry);
  EXPECT_EQ(chain.num_edges(), 21);  // 19, and two more between the first poses
  const RobustSolution robust = SolveRobustPoseGraph(chain);
  EXPECT_EQ(robust.num_closures, 0);
  EXPECT_EQ(robust.num_rejected, 0);
  EXPECT_EQ(robust.solution.poses, SolvePoseGraph(chain).poses);
}

TYPED_TEST(RobustPoseGraph, KeepsAClosureThatAloneJoinsTwoParts) {
  PoseGraph graph = test::RingGraph<TypeParam>(20, 0.01, 1, 1);
  std::vector<bool> kept(static_cast<std::size_t>(graph.num_edges()), false);
  for (Index e = 0; e < graph.num_edges(); ++e) kept[static_cast<std::size_t>(e)] = IsOdometry(graph, e);
  graph = WithEdges(graph, kept);
  for (Index i = 10; i < 20; ++i) graph.ids[static_cast<std::size_t>(i)] += 100;
  const RobustSolution robust = SolveRobustPoseGraph(graph);
  EXPECT_EQ(robust.num_closures, 1);
  EXPECT_EQ(robust.num_rejected, 0);
}

TYPED_TEST(RobustPoseGraph, LimitsHoldForAllSolvesTogether) {
  const PoseGraph graph = this->WithWrongClosures(test::RingGraph<TypeParam>(60, 0.05, 1, 1), 6, 2);
  const RobustSolution whole = SolveRobustPoseGraph(graph);
  ASSERT_GT(whole.num_solves, 1);
  int num_iterations = 0;
  const LmCallback count = [&](const LmIteration& row) {
    num_iterations += row.iteration > 0 ? 1 : 0;
    return CallbackResult::kContinue;
  };
  RobustSolveOptions options;
  options.solve.lm.max_iterations = 2;
  SolveRobustPoseGraph(graph, options, count);
  EXPECT_EQ(num_iterations, 2);
  options.solve.lm = PoseGraphOptions();
  options.solve.lm.max_seconds = 0;
  num_iterations = 0;
  const RobustSolution none = SolveRobustPoseGraph(graph, options, count);
  EXPECT_EQ(none.solution.summary.status, LmStatus::kTimeLimit);
  EXPECT_EQ(none.num_solves, 1);
  EXPECT_EQ(num_iterations, 0);
}

TEST(RobustPoseGraphOptions, BadValuesThrow) {
  const PoseGraph graph = test::RingGraph<Se2>(10, 0.01, 1, 1);
  RobustSolveOptions options;
  options.significance = 0;
  EXPECT_THROW(SolveRobustPoseGraph(graph, options), Error);
  options.significance = 1;
  EXPECT_THROW(SolveRobustPoseGraph(graph, options), Error);
  options.significance = 0.05;
  options.solve.problem.loss = std::make_shared<HuberLoss>(1);
  EXPECT_THROW(SolveRobustPoseGraph(graph, options), Error);
}

}  // namespace
}  // namespace vesta::pose_graph
