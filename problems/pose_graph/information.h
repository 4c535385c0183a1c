// Information matrices and their square roots.
#pragma once

namespace vesta::pose_graph {

// Lower Cholesky factor L, row-major size x size with zeros above the diagonal, of the matrix given by its upper
// triangle, row by row; size <= 6. false when it is not positive definite (L then holds no meaning).
bool FactorInformation(const double* upper, int size, double* lower);

}  // namespace vesta::pose_graph
