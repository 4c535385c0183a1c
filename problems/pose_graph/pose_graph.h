// SPDX-License-Identifier: Apache-2.0
// A pose graph: poses and landmarks, and relative measurements between pairs of them.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::pose_graph {

// Steps and residuals: problems/pose_graph/poses.h.
enum class PoseSpace { kSe2, kSe3 };

// Values per pose: (x, y, yaw) in 2D; position (x, y, z) and unit quaternion (w, x, y, z) in 3D.
constexpr int PoseSize(PoseSpace space) { return space == PoseSpace::kSe2 ? 3 : 7; }
// Dimension of a step of one pose, and of an edge's residual.
constexpr int TangentSize(PoseSpace space) { return space == PoseSpace::kSe2 ? 3 : 6; }
// Dimension of a position.
constexpr int PositionSize(PoseSpace space) { return space == PoseSpace::kSe2 ? 2 : 3; }
// Values per information matrix: its upper triangle, row by row.
constexpr int InformationSize(PoseSpace space) { return space == PoseSpace::kSe2 ? 6 : 21; }

struct PoseGraph {
  // A measurement of pose `to` relative to pose `from`; indices of poses. A landmark is only `to`.
  struct Edge {
    Index from = 0, to = 0;
  };

  PoseSpace space = PoseSpace::kSe2;
  std::vector<Index> ids = {};     // vertex id of each pose in the file
  std::vector<double> poses = {};  // PoseSize values per pose, in the world frame
  bool has_poses = true;           // false: the file had edges alone, and all poses are the identity
  std::vector<Index> fixed = {};   // indices of the fixed poses, ascending, unique
  // Indices of the landmarks, ascending, unique. A landmark is a pose whose rotation is the identity and stays so.
  std::vector<Index> landmarks = {};
  // Index of the pose of the world's frame, the identity and fixed; -1 without priors. Edges from it are priors.
  Index world = -1;
  std::vector<Edge> edges = {};
  std::vector<double> measurements = {};  // PoseSize values per edge: pose `to` in the frame of pose `from`
  // InformationSize values per edge: inverse covariance of the residual, in its order. For a landmark, entries of the
  // rotation are 0.
  std::vector<double> information = {};
  std::vector<std::string> notes = {};  // remarks of the file reader, one line each

  Index num_poses() const { return static_cast<Index>(ids.size()); }
  Index num_edges() const { return static_cast<Index>(edges.size()); }
  bool IsLandmark(Index pose) const { return std::binary_search(landmarks.begin(), landmarks.end(), pose); }
};

}  // namespace vesta::pose_graph
