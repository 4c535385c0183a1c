// SPDX-License-Identifier: Apache-2.0
// Pose graphs with wrong loop closures.
#pragma once

#include <cstdint>
#include <vector>

#include "problems/pose_graph/pose_graph.h"

namespace vesta::bench {

// Root mean square difference of the positions, world units.
double PositionDifference(const pose_graph::PoseGraph& graph, const std::vector<double>& a,
                          const std::vector<double>& b);

struct WrongClosures {
  double fraction = 0.1;  // relative to the number of the graph's closures (pose_graph::IsOdometry); >= 0
  double size = 1;        // of their positions, in extents of graph.poses; > 0
  std::uint64_t seed = 0;
};

// The graph with wrong closures after its own edges. They join random pairs of poses that are not consecutive, by a
// uniformly random rotation and a position that is uniform in a cube. The cube has the extent of graph.poses, times
// `size`. Each has the information matrix of a random closure of the graph, which needs at least one.
pose_graph::PoseGraph WithWrongClosures(pose_graph::PoseGraph graph, const WrongClosures& options);

}  // namespace vesta::bench
