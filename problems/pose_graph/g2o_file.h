// SPDX-License-Identifier: Apache-2.0
// Pose graphs in the text format of g2o (Kuemmerle et al., g2o: a general framework for graph optimization, 2011).
#pragma once

#include <string>

#include "problems/pose_graph/pose_graph.h"

namespace vesta::pose_graph {

struct G2oOptions {
  // Replaces indefinite information matrices by the nearest positive semidefinite ones: negative eigenvalues become 0.
  // PoseGraph::notes reports these matrices. False: they are errors.
  bool clip_indefinite = false;
};

// Reads a file with one record per line; angles in radians:
//   VERTEX_SE2 id x y yaw
//   VERTEX_SE3:QUAT id x y z qx qy qz qw
//   EDGE_SE2 from to x y yaw, then the upper triangle of the information matrix, row by row: 6 numbers
//   EDGE_SE3:QUAT from to x y z qx qy qz qw, then the same: 21 numbers
//   FIX id ...
//   # comment
// Landmarks, and measurements of their positions from a pose, with information matrices of 3 or 6 numbers:
//   VERTEX_XY id x y
//   VERTEX_TRACKXYZ id x y z
//   EDGE_SE2_XY pose landmark x y, information
//   EDGE_SE3_TRACKXYZ pose landmark offset x y z, information
// Priors of a pose in the world's frame (PoseGraph::world); of its position alone, with EDGE_PRIOR_SE2_XY:
//   EDGE_PRIOR_SE2 id x y yaw, information
//   EDGE_PRIOR_SE2_XY id x y, information: 3 numbers
//   EDGE_SE3_PRIOR id offset x y z qx qy qz qw, information
// `offset` is the id of a sensor's pose; only the identity is supported:
//   PARAMS_SE3OFFSET offset 0 0 0 0 0 0 1
// Vertices may come after their edges. A file of edges alone defines the vertices that they join
// (PoseGraph::has_poses is false). Quaternions are normalised, because files contain rounded values. Singular
// information matrices are accepted, with a note. Throws Error, naming the file and the line, for:
//   unknown tags, 2D and 3D poses in one file, missing or superfluous words, numbers that are not finite;
//   repeated or unknown ids, an edge from a vertex to itself, a landmark instead of a pose, or the reverse;
//   a quaternion far from unit length, an indefinite information matrix (unless options.clip_indefinite).
PoseGraph ReadG2o(const std::string& path, const G2oOptions& options = {});

// Writes a file from which ReadG2o reads the same bits (quaternions: up to rounding). Throws Error if writing fails.
void WriteG2o(const PoseGraph& graph, const std::string& path);

}  // namespace vesta::pose_graph
