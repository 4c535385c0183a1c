// SPDX-License-Identifier: Apache-2.0
// Pose graphs in g2o files, and the square roots of their information matrices.
//
// Pose graphs in the text format of g2o (Kuemmerle et al., g2o: a general framework for graph optimization, 2011).
#pragma once

#include <string>

#include "problems/pose_graph/pose_graph.h"

namespace vesta::pose_graph {

struct G2oOptions {
  // Indefinite information matrices, which belong to no covariance, are replaced by the nearest semidefinite ones:
  // negative eigenvalues become 0. With a note.
  bool clip_indefinite = false;
};

// One record a line: VERTEX_SE2 id x y yaw; VERTEX_SE3:QUAT id x y z qx qy qz qw; EDGE_SE2 and EDGE_SE3:QUAT from to
// measurement information (upper triangle, row by row); FIX id ...; lines that begin with # are comments. Vertices may
// come after the edges that name them. Quaternions are brought to unit length, since files round them. Throws Error,
// one line that names the file and the line, at anything else: unknown tags, both kinds of pose in one file, missing or
// superfluous words, numbers that are not finite, repeated or unknown ids, an edge from a vertex to itself, a zero
// quaternion, an indefinite information matrix (unless they are to be clipped). Semidefinite ones are kept, with a
// note.
PoseGraph ReadG2o(const std::string& path, const G2oOptions& options = {});

// Writes what ReadG2o reads back with the same bits (quaternions to within rounding).
void WriteG2o(const PoseGraph& graph, const std::string& path);

// Of a symmetric matrix, which is given by its upper triangle, row by row; size <= 6.
struct Spectrum {
  bool semidefinite = false;  // no eigenvalue below 0 but by rounding: 1e-12 of the largest
  double least = 0, largest = 0;
};
// NaN and infinity are not semidefinite.
Spectrum SpectrumOf(const double* upper, int size);

// Square root L of such a matrix, L L^T, row-major size x size. Where the matrix is positive definite this is its lower
// Cholesky factor, with zeros above the diagonal, and the result is true. Else it is the symmetric square root of the
// nearest semidefinite matrix: of this one, but for rounding, where it is semidefinite itself.
bool FactorInformation(const double* upper, int size, double* root);

}  // namespace vesta::pose_graph
