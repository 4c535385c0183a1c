// SPDX-License-Identifier: Apache-2.0
// A path around a ring with chords across it, with noisy measurements.
#pragma once

#include <algorithm>
#include <numbers>
#include <vector>

#include "problems/pose_graph/information.h"
#include "problems/pose_graph/pose_graph_problem.h"
#include "problems/pose_graph/poses.h"
#include "tests/support/random.h"

namespace vesta::test {

// G G^T + I with random G, as upper triangle, row by row.
inline std::vector<double> RandomInformation(int size, Random* random) {
  const auto n = static_cast<std::size_t>(size);
  const std::vector<double> g = random->NormalVector<double>(n * n);
  std::vector<double> upper;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = i; k < n; ++k) {
      double sum = i == k ? 1 : 0;
      for (std::size_t j = 0; j < n; ++j) sum += g[n * i + j] * g[n * k + j];
      upper.push_back(sum);
    }
  }
  return upper;
}

// The measurement of pose b from pose a with zero residual.
template <class Space>
std::vector<double> ExactMeasurement(const double* a, const double* b) {
  std::vector<double> measurement(Space::kPose);
  if constexpr (Space::kPose == 7) measurement[3] = 1;
  double residual[Space::kTangent];
  Space::Residual(a, b, measurement.data(), residual);
  if constexpr (Space::kPose == 7) {
    double inverse[4];
    QuaternionConjugate(a + 3, inverse);
    std::copy(residual, residual + 3, measurement.begin());
    QuaternionProduct(inverse, b + 3, measurement.data() + 3);
  } else {
    std::copy(residual, residual + 3, measurement.begin());
  }
  return measurement;
}

// On a ring of radius 10; each pose is joined to the next, and every third to the opposite one. Poses and measurements
// have noise; information matrices are random. With id_step = 1, edges of the
// path are odometry.
template <class Space>
pose_graph::PoseGraph RingGraph(Index num_poses, double noise, std::uint64_t seed, Index id_step = 3) {
  constexpr auto kPose = static_cast<std::size_t>(Space::kPose);
  Random random(seed);
  pose_graph::PoseGraph graph;
  graph.space = Space::kPose == 7 ? pose_graph::PoseSpace::kSe3 : pose_graph::PoseSpace::kSe2;
  const auto moved = [&](const double* pose, double size) {
    std::vector<double> delta = random.NormalVector<double>(Space::kTangent), result(kPose);
    for (double& d : delta) d *= size;
    Space::Plus(pose, delta.data(), result.data());
    return result;
  };
  std::vector<double> truth;
  for (Index i = 0; i < num_poses; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(num_poses);
    std::vector<double> pose = {10 * std::cos(angle), 10 * std::sin(angle), angle};
    if (Space::kPose == 7) pose = {pose[0], pose[1], 0.3 * angle, std::cos(angle / 2), 0, 0, std::sin(angle / 2)};
    pose = moved(pose.data(), 0.1);
    truth.insert(truth.end(), pose.begin(), pose.end());
    const std::vector<double> start = moved(pose.data(), noise);
    graph.poses.insert(graph.poses.end(), start.begin(), start.end());
    graph.ids.push_back(100 + id_step * i);
  }
  const auto join = [&](Index from, Index to) {
    const double* poses = truth.data();
    const std::vector<double> exact = ExactMeasurement<Space>(poses + from * Space::kPose, poses + to * Space::kPose);
    const std::vector<double> measured = moved(exact.data(), noise);
    graph.edges.push_back({from, to});
    graph.measurements.insert(graph.measurements.end(), measured.begin(), measured.end());
    const std::vector<double> information = RandomInformation(Space::kTangent, &random);
    graph.information.insert(graph.information.end(), information.begin(), information.end());
  };
  for (Index i = 0; i < num_poses; ++i) {
    join(i, (i + 1) % num_poses);
    if (i % 3 == 0) join((i + num_poses / 2) % num_poses, i);
  }
  // The same pair in both directions.
  join(0, 1);
  join(1, 0);
  return graph;
}

// Adds an edge with the information of the first one.
inline void AddEdge(pose_graph::PoseGraph& graph, Index from, Index to, const std::vector<double>& measurement) {
  graph.edges.push_back({from, to});
  graph.measurements.insert(graph.measurements.end(), measurement.begin(), measurement.end());
  const std::vector<double> information(graph.information.begin(),
                                        graph.information.begin() + InformationSize(graph.space));
  graph.information.insert(graph.information.end(), information.begin(), information.end());
}

// Adds three landmarks, each measured from four poses, and priors of two poses. The measurements are exact for
// graph.poses.
template <class Space>
void AddLandmarksAndPriors(pose_graph::PoseGraph& graph, std::uint64_t seed) {
  constexpr auto kPose = static_cast<std::size_t>(Space::kPose);
  constexpr int kPosition =
      pose_graph::PositionSize(Space::kPose == 7 ? pose_graph::PoseSpace::kSe3 : pose_graph::PoseSpace::kSe2);
  Random random(seed);
  const Index num_poses = graph.num_poses();
  const auto add_pose = [&](const std::vector<double>& position) {
    std::vector<double> pose(kPose, 0.0);
    if (kPose == 7) pose[3] = 1;
    std::copy(position.begin(), position.end(), pose.begin());
    graph.poses.insert(graph.poses.end(), pose.begin(), pose.end());
    graph.ids.push_back(-1 - graph.num_poses());
    return graph.num_poses() - 1;
  };
  const auto join = [&](Index from, Index to, bool measures_position) {
    const double* poses = graph.poses.data();
    std::vector<double> exact = ExactMeasurement<Space>(poses + from * Space::kPose, poses + to * Space::kPose);
    std::vector<double> information(static_cast<std::size_t>(InformationSize(graph.space)));
    if (measures_position) {
      std::fill(exact.begin() + kPosition, exact.end(), 0.0);
      if (kPose == 7) exact[3] = 1;
      FromPositionBlock(graph.space, RandomInformation(kPosition, &random).data(), information.data());
    } else {
      information = RandomInformation(Space::kTangent, &random);
    }
    graph.edges.push_back({from, to});
    graph.measurements.insert(graph.measurements.end(), exact.begin(), exact.end());
    graph.information.insert(graph.information.end(), information.begin(), information.end());
  };
  for (int k = 0; k < 3; ++k) {
    graph.landmarks.push_back(add_pose(random.NormalVector<double>(static_cast<std::size_t>(kPosition))));
    for (Index i = 0; i < 4; ++i) join((3 * i + k) % num_poses, graph.landmarks.back(), true);
  }
  graph.world = add_pose({});
  graph.fixed.push_back(graph.world);
  join(graph.world, 0, false);
  join(graph.world, num_poses / 2, Space::kPose == 3);
}

inline CpuBackend<double>::Vector Start(const pose_graph::PoseGraphProblem& problem) {
  CpuBackend<double>::Vector x(problem.num_parameters());
  std::copy(problem.start().begin(), problem.start().end(), x.begin());
  return x;
}

}  // namespace vesta::test
