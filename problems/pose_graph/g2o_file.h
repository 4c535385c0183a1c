// SPDX-License-Identifier: Apache-2.0
// Pose graphs in the text format of g2o (Kuemmerle et al., g2o: a general framework for graph optimization, 2011), and
// square roots of information matrices.
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
// Vertices may come after their edges. A file of edges alone defines the vertices that they join
// (PoseGraph::has_poses is false). Quaternions are normalised, because files contain rounded values. Singular
// information matrices are accepted, with a note. Throws Error, naming the file and the line, for:
//   unknown tags, 2D and 3D poses in one file, missing or superfluous words, numbers that are not finite;
//   repeated or unknown ids, an edge from a vertex to itself;
//   a quaternion far from unit length, an indefinite information matrix (unless options.clip_indefinite).
PoseGraph ReadG2o(const std::string& path, const G2oOptions& options = {});

// Writes a file from which ReadG2o reads the same bits (quaternions: up to rounding). Throws Error if writing fails.
void WriteG2o(const PoseGraph& graph, const std::string& path);

// Eigenvalues of a symmetric matrix.
struct Spectrum {
  bool semidefinite = false;  // no eigenvalue below -1e-12 times the largest
  double least = 0, largest = 0;
};
// upper: the upper triangle, row by row; size <= 6. A matrix with NaN or infinity is not semidefinite.
Spectrum SpectrumOf(const double* upper, int size);

// Writes the square root L of a symmetric matrix, L L^T = matrix, to `root`: row-major size x size. For a positive
// definite matrix, L is the lower Cholesky factor and the result is true. Otherwise the result is false, and L is the
// symmetric square root of the nearest positive semidefinite matrix.
bool FactorInformation(const double* upper, int size, double* root);

}  // namespace vesta::pose_graph
