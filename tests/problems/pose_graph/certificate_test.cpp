// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/certificate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "problems/pose_graph/solve.h"
#include "tests/problems/pose_graph/ring_graph.h"
#include "tests/support/test_files.h"

namespace vesta::pose_graph {
namespace {

PoseGraphSolveOptions Isotropic(Initialize initialize = Initialize::kAuto) {
  PoseGraphSolveOptions options;
  options.problem.error = EdgeError::kIsotropic;
  options.initialize = initialize;
  options.lm.max_iterations = 200;
  options.lm.function_tolerance = 1e-14;
  return options;
}

template <class Space>
class Certificates : public testing::Test {};
using Spaces = testing::Types<Se2, Se3>;
TYPED_TEST_SUITE(Certificates, Spaces);

TYPED_TEST(Certificates, ProveTheMinimumOfARing) {
  const PoseGraph graph = test::RingGraph<TypeParam>(40, 0.05, 1);
  const PoseGraphSolution solution = SolvePoseGraph(graph, Isotropic());
  const Certificate certificate = Certify(graph, solution.poses);
  EXPECT_NEAR(certificate.cost, solution.summary.final_cost, 1e-10 * certificate.cost);
  EXPECT_LE(certificate.lower_bound, certificate.cost);
  EXPECT_TRUE(certificate.is_optimal()) << certificate.gap();
}

TYPED_TEST(Certificates, BoundTheCostOfOtherPosesToo) {
  const PoseGraph graph = test::RingGraph<TypeParam>(40, 0.05, 1);
  const double least = SolvePoseGraph(graph, Isotropic()).summary.final_cost;
  const Certificate certificate = Certify(graph, graph.poses);
  EXPECT_GT(certificate.cost, least);
  EXPECT_LE(certificate.lower_bound, least);
  EXPECT_FALSE(certificate.is_optimal());
}

// A closed path that turns once has other minima, in which it turns more often.
TEST(Certificate, AWorseMinimumIsNotProven) {
  constexpr int kPoses = 24;
  PoseGraph graph;
  const auto turns = [&](int times) {
    std::vector<double> poses;
    for (int i = 0; i < kPoses; ++i) {
      const double angle = 2 * std::numbers::pi * times * i / kPoses;
      poses.insert(poses.end(), {std::sin(angle), 1 - std::cos(angle), angle});
    }
    return poses;
  };
  const double step = 2 * std::numbers::pi / kPoses;
  for (Index i = 0; i < kPoses; ++i) {
    graph.ids.push_back(i);
    graph.edges.push_back({i, (i + 1) % kPoses});
    for (const double value : {2 * std::sin(step / 2) * std::cos(step / 2), 2 * std::sin(step / 2) * std::sin(step / 2),
                               step + 1e-3 * (i % 3)}) {
      graph.measurements.push_back(value);
    }
    for (const double value : {1.0, 0.0, 0.0, 1.0, 0.0, 10.0}) graph.information.push_back(value);
  }
  graph.poses = turns(2);
  const PoseGraphSolution worse = SolvePoseGraph(graph, Isotropic(Initialize::kGiven));
  const PoseGraphSolution best = SolvePoseGraph(graph, Isotropic());
  EXPECT_GT(worse.summary.final_cost, 100 * best.summary.final_cost);
  EXPECT_LT(worse.summary.final_cost, 0.999 * worse.summary.initial_cost);
  EXPECT_FALSE(Certify(graph, worse.poses).is_optimal());
  EXPECT_LE(Certify(graph, worse.poses).lower_bound, best.summary.final_cost);
  EXPECT_TRUE(Certify(graph, best.poses).is_optimal());
}

TEST(Certificate, WithoutInformationTheBoundIsZero) {
  const PoseGraph alone{.ids = {0}, .poses = {1, 2, 0.5}};
  EXPECT_EQ(Certify(alone, alone.poses).lower_bound, 0);
  EXPECT_TRUE(Certify(alone, alone.poses).is_optimal());
  PoseGraph infinite = test::RingGraph<Se2>(5, 0.1, 1);
  for (double& value : infinite.information) value *= 1e308;
  EXPECT_FALSE(Certify(infinite, infinite.poses).lower_bound > 0);
}

TEST(Certificate, NeedsOneFixedPose) {
  PoseGraph graph = test::RingGraph<Se2>(20, 0.1, 1);
  graph.fixed = {2};
  EXPECT_NO_THROW(Certify(graph, graph.poses));
  graph.fixed = {2, 5};
  EXPECT_THAT([&] { Certify(graph, graph.poses); }, ThrowsError(kUnsupported, "fixed"));
}

}  // namespace
}  // namespace vesta::pose_graph
