// SPDX-License-Identifier: Apache-2.0
// Reads and writes pose graphs in the text format of g2o (Kuemmerle et al., g2o: a general framework for graph
// optimization, 2011). Also computes square roots of information matrices.
#pragma once

#include <string>

#include "problems/pose_graph/pose_graph.h"

namespace vesta::pose_graph {

struct G2oOptions {
  // Replaces indefinite information matrices, which no covariance has, by the nearest semidefinite ones: negative
  // eigenvalues become 0. PoseGraph::notes reports them.
  bool clip_indefinite = false;
};

// One record per line: VERTEX_SE2 id x y yaw; VERTEX_SE3:QUAT id x y z qx qy qz qw; EDGE_SE2 and EDGE_SE3:QUAT from to
// measurement information (upper triangle, row by row); FIX id ...; lines that begin with # are comments. Vertices may
// come after the edges that refer to them. Quaternions are normalised, because files contain rounded values.
// Semidefinite information matrices are kept, with a note.
// Throws Error with one line that names the file and the line: for unknown tags, 2D and 3D poses in one file, missing
// or superfluous words, and numbers that are not finite; for repeated or unknown ids, and an edge from a vertex to
// itself; for a quaternion far from unit length, and an indefinite information matrix (unless options.clip_indefinite).
PoseGraph ReadG2o(const std::string& path, const G2oOptions& options = {});

// Writes a file that ReadG2o reads back bit for bit (quaternions to within rounding).
void WriteG2o(const PoseGraph& graph, const std::string& path);

// Eigenvalues of a symmetric matrix, given by its upper triangle, row by row; size <= 6.
struct Spectrum {
  bool semidefinite = false;  // no eigenvalue below 0, except for rounding: 1e-12 of the largest
  double least = 0, largest = 0;
};
// A matrix with NaN or infinity is not semidefinite.
Spectrum SpectrumOf(const double* upper, int size);

// Square root L of such a matrix, L L^T, row-major size x size. If the matrix is positive definite, this is its lower
// Cholesky factor, with zeros above the diagonal, and the result is true. Otherwise it is the symmetric square root of
// the nearest semidefinite matrix, which is the matrix itself if that is semidefinite.
bool FactorInformation(const double* upper, int size, double* root);

}  // namespace vesta::pose_graph
