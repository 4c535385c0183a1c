// SPDX-License-Identifier: Apache-2.0
// Information matrices and their square roots.
#pragma once

namespace vesta::pose_graph {

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
