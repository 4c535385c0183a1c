// SPDX-License-Identifier: Apache-2.0
// Information matrices: their eigenvalues, square roots and position blocks. A matrix is given by its upper triangle,
// row by row, as in PoseGraph::information.
#pragma once

#include "problems/pose_graph/pose_graph.h"

namespace vesta::pose_graph {

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

// The block of the position in an information matrix, and a matrix that has this block and is 0 elsewhere.
// position: PositionSize (PositionSize + 1) / 2 values; full: InformationSize values.
void PositionBlock(PoseSpace space, const double* full, double* position);
void FromPositionBlock(PoseSpace space, const double* position, double* full);

}  // namespace vesta::pose_graph
