// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/information.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace vesta::pose_graph {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, 6, 6>;

Matrix Full(const double* upper, int size) {
  Matrix full(size, size);
  for (int row = 0; row < size; ++row) {
    for (int col = row; col < size; ++col) full(row, col) = full(col, row) = *upper++;
  }
  return full;
}

// Returns false if the matrix is not positive definite; `lower` is then undefined.
bool Cholesky(const double* upper, int size, double* lower) {
  for (int row = 0; row < size; ++row) {
    for (int col = 0; col < size; ++col) lower[row * size + col] = 0;
  }
  // The rows of the upper triangle are the columns of L.
  for (int col = 0; col < size; ++col) {
    for (int row = col; row < size; ++row, ++upper) {
      double value = *upper;
      for (int k = 0; k < col; ++k) value -= lower[row * size + k] * lower[col * size + k];
      if (row == col) {
        if (!(value > 0) || !std::isfinite(value)) return false;
        lower[col * size + col] = std::sqrt(value);
      } else {
        lower[row * size + col] = value / lower[col * size + col];
      }
    }
  }
  return true;
}

}  // namespace

Spectrum SpectrumOf(const double* upper, int size) {
  const Matrix full = Full(upper, size);
  if (!full.allFinite()) return {};
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(full, Eigen::EigenvaluesOnly);
  const double least = solver.eigenvalues()[0], largest = solver.eigenvalues()[size - 1];
  return {largest >= 0 && least >= -1e-12 * largest, least, largest};
}

bool FactorInformation(const double* upper, int size, double* root) {
  if (Cholesky(upper, size, root)) return true;
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(Full(upper, size));
  const auto& vectors = solver.eigenvectors();
  Eigen::Map<Matrix>(root, size, size) =
      vectors * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * vectors.transpose();
  return false;
}

namespace {

// Calls visit(entry of the full matrix, entry of the position block, or null outside of it).
template <class Full, class Position, class Visit>
void VisitBlock(PoseSpace space, Full* full, Position* position, const Visit& visit) {
  for (int row = 0; row < TangentSize(space); ++row) {
    for (int col = row; col < TangentSize(space); ++col) {
      visit(full++, col < PositionSize(space) ? position++ : nullptr);
    }
  }
}

}  // namespace

void PositionBlock(PoseSpace space, const double* full, double* position) {
  VisitBlock(space, full, position, [](const double* from, double* to) {
    if (to) *to = *from;
  });
}

void FromPositionBlock(PoseSpace space, const double* position, double* full) {
  VisitBlock(space, full, position, [](double* to, const double* from) { *to = from ? *from : 0; });
}

}  // namespace vesta::pose_graph
