// SPDX-License-Identifier: Apache-2.0
// Rotation averaging: rotations of all views from rotations of pairs. Position averaging: positions from directions.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "kernels/core/check.h"
#include "problems/pose_graph/chordal.h"
#include "problems/pose_graph/pose_graph_problem.h"
#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"
#include "views.h"

constexpr double kLargestError = 5 * kDegree;    // of the rotation of a correct pair
constexpr double kDirectionError = 1 * kDegree;  // scale of the robust loss of directions

// The pairs' rotations as a pose graph. All positions are 0, so only rotations have errors.
inline vesta::pose_graph::PoseGraph RotationGraph(Index views, const std::vector<Pair>& pairs) {
  vesta::pose_graph::PoseGraph graph{.space = vesta::pose_graph::PoseSpace::kSe3, .has_poses = false};
  for (Index i = 0; i < views; ++i) {
    graph.ids.push_back(i);
    graph.poses.insert(graph.poses.end(), {0, 0, 0, 1, 0, 0, 0});
  }
  for (const auto& [from, to, q, direction] : pairs) {
    graph.edges.push_back({from, to});
    graph.measurements.insert(graph.measurements.end(), {0, 0, 0, q.w(), q.x(), q.y(), q.z()});
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) graph.information.push_back(row == column ? 1 : 0);
    }
  }
  const std::vector<bool> held = vesta::pose_graph::HeldPoses(graph);
  const auto parts = std::count(held.begin(), held.end(), true);
  VESTA_CHECK(parts == 1, "the pairs connect the {} cameras to {} separate groups, not to one", views, parts);
  return graph;
}

// Starts from chordal relaxation, a linear problem. Wrong pairs distort its result, so solves with a robust loss follow
// (Chatterjee and Govindu 2013, "Efficient and robust large-scale rotation averaging"). The scale of the loss decreases
// from solve to solve (Yang et al. 2020, "Graduated non-convexity for robust spatial perception"). The last scale
// alone might not correct views that chordal relaxation rotates wrongly.
inline std::vector<View> AverageRotations(Index count, const std::vector<Pair>& pairs) {
  namespace pg = vesta::pose_graph;
  const pg::PoseGraph graph = RotationGraph(count, pairs);
  std::optional<std::vector<double>> poses = pg::ChordalPoses(graph);
  VESTA_CHECK(poses, "chordal relaxation of {} pairs needs too much memory", pairs.size());
  for (double scale = 4; scale > kLargestError / 2; scale /= 2) {
    const auto loss = std::make_shared<vesta::CauchyLoss>(scale);
    pg::PoseGraphProblem problem(graph, {.error = pg::EdgeError::kIsotropic, .loss = loss});
    vesta::SolveLm(problem, *poses, pg::PoseGraphOptions());
  }
  std::vector<View> views(count);
  for (Index i = 0; i < count; ++i) {
    const double* q = poses->data() + 7 * i + 3;
    views[i].rotation = {q[0], q[1], q[2], q[3]};
  }
  return views;
}

inline bool IsCorrect(const Pair& pair, const std::vector<View>& views) {
  return views[pair.to].rotation.angularDistance(views[pair.from].rotation * pair.rotation) < kLargestError;
}

// Error of a position: to - from - distance * direction.
struct OffsetError {
  Vector3d direction;

  template <class T>
  void operator()(const T* from, const T* to, const T* distance, T* r) const {
    for (int k = 0; k < 3; ++k) r[k] = to[k] - from[k] - distance[0] * T(direction[k]);
  }
};

// Error of a direction: (to - from) / |to - from| - direction.
struct DirectionError {
  Vector3d direction;

  template <class T>
  void operator()(const T* from, const T* to, T* r) const {
    using std::sqrt;
    const T offset[3] = {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    const T length = sqrt(vesta::DotProduct(offset, offset));
    for (int k = 0; k < 3; ++k) r[k] = offset[k] / length - T(direction[k]);
  }
};

// A problem with a block of three coordinates per node. The first node is constant.
inline vesta::BlockProblem NodeProblem(Index nodes) {
  vesta::BlockProblem problem;
  for (Index i = 0; i < nodes; ++i) problem.AddParameterBlock(3);
  problem.SetConstant(0);
  return problem;
}

// Positions by least unsquared deviations (Ozyesil and Singer 2015, "Robust camera location estimation by convex
// programming"). The unknown distance of each sight is at least 1: this fixes the scale, and nodes cannot all coincide.
// The problem is convex, so the start does not matter. Huber's loss makes the norm smooth at 0.
inline std::vector<double> StartPositions(Index count, const std::vector<Sight>& sights) {
  vesta::BlockProblem problem = NodeProblem(count);
  const auto loss = std::make_shared<vesta::HuberLoss>(0.1);
  std::vector<double> x(3 * count, 0.0);
  for (const auto& [from, to, direction] : sights) {
    const int distance = problem.AddParameterBlock(1);
    problem.SetBounds(distance, 0, 1, std::numeric_limits<double>::infinity());
    x.push_back(1);
    problem.AddResidualBlock(std::make_shared<vesta::AutoDiffCost<OffsetError, 3, 3, 3, 1>>(OffsetError{direction}),
                             loss, {static_cast<int>(from), static_cast<int>(to), distance});
  }
  vesta::LmOptions options;
  options.max_iterations = 100;
  options.normal_system.preconditioner = vesta::PreconditionerKind::kSparseCholesky;
  vesta::SolveLm(problem, x, options);
  x.resize(3 * count);
  return x;
}

// Minimises the errors of the directions with a robust loss (Wilson and Snavely 2014, "Robust global translations with
// 1DSfM"). The directions do not determine the scale, which stays close to the scale of the start.
inline void RefinePositions(const std::vector<Sight>& sights, std::vector<double>& nodes) {
  vesta::BlockProblem problem = NodeProblem(static_cast<Index>(nodes.size()) / 3);
  const auto loss = std::make_shared<vesta::CauchyLoss>(kDirectionError);
  for (const auto& [from, to, direction] : sights) {
    problem.AddResidualBlock(std::make_shared<vesta::AutoDiffCost<DirectionError, 3, 3, 3>>(DirectionError{direction}),
                             loss, {static_cast<int>(from), static_cast<int>(to)});
  }
  vesta::LmOptions options;
  options.max_iterations = 200;
  vesta::SolveLm(problem, nodes, options);
}
