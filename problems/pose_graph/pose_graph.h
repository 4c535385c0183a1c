// SPDX-License-Identifier: Apache-2.0
// A pose graph: poses, and relative measurements between some pairs of them.
#pragma once

#include <string>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::pose_graph {

// How poses are stored and moved: problems/pose_graph/poses.h.
enum class PoseSpace { kSe2, kSe3 };

// Numbers of a pose: (x, y, yaw), or position (x, y, z) and unit quaternion (w, x, y, z).
constexpr int PoseSize(PoseSpace space) { return space == PoseSpace::kSe2 ? 3 : 7; }
// Numbers of a step of a pose, and of the residual of an edge.
constexpr int TangentSize(PoseSpace space) { return space == PoseSpace::kSe2 ? 3 : 6; }
// Numbers of an information matrix: its upper triangle, row by row.
constexpr int InformationSize(PoseSpace space) { return space == PoseSpace::kSe2 ? 6 : 21; }

struct PoseGraph {
  // Positions among the poses.
  struct Edge {
    Index from = 0, to = 0;
  };

  PoseSpace space = PoseSpace::kSe2;
  std::vector<Index> ids = {};     // the poses' names
  std::vector<double> poses = {};  // PoseSize for each: pose in the world's frame
  std::vector<Index> fixed = {};   // positions of the poses that do not move, ascending, no repeats
  std::vector<Edge> edges = {};
  std::vector<double> measurements = {};  // PoseSize for each edge: pose `to` as seen from pose `from`
  std::vector<double> information =
      {};  // InformationSize for each edge: inverse covariance of the residual, in its order
  std::vector<std::string> notes = {};  // what a reader found worth saying, a line each

  Index num_poses() const { return static_cast<Index>(ids.size()); }
  Index num_edges() const { return static_cast<Index>(edges.size()); }
};

}  // namespace vesta::pose_graph
