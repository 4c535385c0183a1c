// SPDX-License-Identifier: Apache-2.0
// The start from the measurements alone, and the solve that uses it.
#include "problems/pose_graph/chordal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "problems/pose_graph/solve.h"
#include "tests/problems/pose_graph/ring_graph.h"

namespace vesta::pose_graph {
namespace {

// Replaces all poses but the first by other ones.
template <class Space>
PoseGraph WithOtherPoses(PoseGraph graph, std::uint64_t seed) {
  test::Random random(seed);
  for (Index i = 1; i < graph.num_poses(); ++i) {
    const std::vector<double> step = random.NormalVector<double>(Space::kTangent);
    std::vector<double> moved(Space::kPose);
    Space::Plus(graph.poses.data() + Space::kPose * i, step.data(), moved.data());
    std::copy(moved.begin(), moved.end(), graph.poses.begin() + Space::kPose * i);
  }
  return graph;
}

template <class Space>
class Chordal : public testing::Test {};
using Spaces = testing::Types<Se2, Se3>;
TYPED_TEST_SUITE(Chordal, Spaces);

TYPED_TEST(Chordal, FindsThePosesOfExactMeasurements) {
  const PoseGraph graph = test::RingGraph<TypeParam>(20, 0, 1);
  const PoseGraph other = WithOtherPoses<TypeParam>(graph, 2);
  const auto poses = ChordalPoses(other);
  ASSERT_TRUE(poses);
  const double cost = PoseGraphProblem(graph).Cost({poses->data(), static_cast<Index>(poses->size())});
  EXPECT_LE(cost, 1e-20);
  for (int k = 0; k < TypeParam::kPose; ++k) EXPECT_EQ((*poses)[static_cast<std::size_t>(k)], graph.poses[k]);
}

TYPED_TEST(Chordal, IgnoresTheOtherPoses) {
  const PoseGraph graph = test::RingGraph<TypeParam>(20, 0.1, 1);
  EXPECT_EQ(ChordalPoses(graph), ChordalPoses(WithOtherPoses<TypeParam>(graph, 2)));
}

TYPED_TEST(Chordal, FixedPosesStay) {
  PoseGraph graph = test::RingGraph<TypeParam>(20, 0.1, 1);
  graph.fixed = {3, 7};
  const auto poses = ChordalPoses(graph);
  ASSERT_TRUE(poses);
  for (const Index i : graph.fixed) {
    for (int k = 0; k < TypeParam::kPose; ++k) {
      const auto at = static_cast<std::size_t>(i * TypeParam::kPose + k);
      EXPECT_EQ((*poses)[at], graph.poses[at]);
    }
  }
  EXPECT_EQ(HeldPoses(graph)[0], false);
}

TYPED_TEST(Chordal, EachComponentHoldsAPose) {
  PoseGraph graph = test::RingGraph<TypeParam>(12, 0, 1);
  const PoseGraph second = test::RingGraph<TypeParam>(9, 0, 2);
  graph.poses.insert(graph.poses.end(), second.poses.begin(), second.poses.end());
  graph.measurements.insert(graph.measurements.end(), second.measurements.begin(), second.measurements.end());
  graph.information.insert(graph.information.end(), second.information.begin(), second.information.end());
  for (const PoseGraph::Edge& edge : second.edges) graph.edges.push_back({edge.from + 12, edge.to + 12});
  for (Index i = 0; i < second.num_poses(); ++i) graph.ids.push_back(1000 + i);
  graph.fixed = {5};
  const std::vector<bool> held = HeldPoses(graph);
  std::vector<bool> expected(21, false);
  expected[5] = expected[12] = true;
  EXPECT_EQ(held, expected);
  const auto poses = ChordalPoses(graph);
  ASSERT_TRUE(poses);
  EXPECT_LE(PoseGraphProblem(graph).Cost({poses->data(), static_cast<Index>(poses->size())}), 1e-20);
}

TYPED_TEST(Chordal, EdgesWithoutInformationDoNotCount) {
  PoseGraph graph = test::RingGraph<TypeParam>(12, 0, 1);
  // A wrong edge of weight 0.
  graph.edges.push_back({2, 6});
  graph.measurements.insert(graph.measurements.end(), graph.poses.begin(), graph.poses.begin() + TypeParam::kPose);
  graph.information.resize(graph.information.size() + static_cast<std::size_t>(InformationSize(graph.space)), 0.0);
  const auto poses = ChordalPoses(graph);
  ASSERT_TRUE(poses);
  EXPECT_LE(PoseGraphProblem(graph).Cost({poses->data(), static_cast<Index>(poses->size())}), 1e-20);
}

TEST(IsotropicWeights, AreHarmonicMeans) {
  PoseGraph graph{.space = PoseSpace::kSe3, .edges = {{0, 1}}, .information = std::vector<double>(21, 0.0)};
  const double diagonal[6] = {1, 2, 4, 10, 20, 40};
  for (int i = 0, at = 0; i < 6; at += 6 - i, ++i) graph.information[static_cast<std::size_t>(at)] = diagonal[i];
  EXPECT_NEAR(IsotropicWeightsOf(graph, 0).translation, 3 / (1 + 1 / 2.0 + 1 / 4.0), 1e-12);
  EXPECT_NEAR(IsotropicWeightsOf(graph, 0).rotation, 3 / (1 + 1 / 2.0 + 1 / 4.0) * 10 / 2, 1e-12);
  const PoseGraph flat{.edges = {{0, 1}}, .information = {2, 1, 0, 2, 0, 5}};
  EXPECT_NEAR(IsotropicWeightsOf(flat, 0).translation, 2 / (1 / 3.0 + 1), 1e-12);
  EXPECT_NEAR(IsotropicWeightsOf(flat, 0).rotation, 2.5, 1e-12);
}

TYPED_TEST(Chordal, IsUsedIfItsCostIsLower) {
  const PoseGraph graph = test::RingGraph<TypeParam>(40, 0.05, 1);
  PoseGraphSolveOptions given;
  given.initialize = Initialize::kGiven;
  const PoseGraphSolution near = SolvePoseGraph(graph, given);
  EXPECT_FALSE(near.starts_chordal);
  EXPECT_TRUE(std::isnan(near.chordal_cost));
  const PoseGraphSolution far = SolvePoseGraph(WithOtherPoses<TypeParam>(graph, 2));
  EXPECT_TRUE(far.starts_chordal);
  EXPECT_LT(far.chordal_cost, far.given_cost);
  EXPECT_NEAR(far.summary.final_cost, near.summary.final_cost, 1e-6 * near.summary.final_cost);

  PoseGraph solved = graph;
  solved.poses = near.poses;
  const PoseGraphSolution again = SolvePoseGraph(solved);
  EXPECT_FALSE(again.starts_chordal);
  EXPECT_LT(again.given_cost, again.chordal_cost);

  PoseGraph edges_alone = graph;
  edges_alone.has_poses = false;
  const PoseGraphSolution unknown = SolvePoseGraph(edges_alone, given);
  EXPECT_TRUE(std::isnan(unknown.given_cost));
}

}  // namespace
}  // namespace vesta::pose_graph
