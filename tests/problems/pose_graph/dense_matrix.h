// Block-sparse matrices for tests, and their dense forms.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <vector>

#include "problems/pose_graph/block_matrix.h"
#include "tests/support/random.h"

namespace vesta::test {

inline Eigen::VectorXd Vector(const std::vector<double>& v) {
  return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

inline Eigen::MatrixXd Dense(const pose_graph::BlockMatrix& matrix) {
  using Block = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  const Index d = matrix.block_size();
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(matrix.size(), matrix.size());
  for (Index row = 0; row < matrix.pattern().num_rows(); ++row) {
    dense.block(row * d, row * d, d, d) = Block(matrix.diagonal(row), d, d);
    for (const auto& neighbor : matrix.pattern().neighbors(row)) {
      if (neighbor.row > row) continue;
      const Block block(matrix.block(neighbor.block), d, d);
      dense.block(row * d, neighbor.row * d, d, d) = block;
      dense.block(neighbor.row * d, row * d, d, d) = block.transpose();
    }
  }
  return dense;
}

// Positive definite, with num_pairs random pairs of rows joined (repeats are one).
inline pose_graph::BlockMatrix RandomMatrix(Index rows, Index num_pairs, int d, Random* random) {
  std::vector<pose_graph::BlockPattern::Pair> pairs;
  while (static_cast<Index>(pairs.size()) < num_pairs) {
    const auto a = static_cast<Index>(random->Uniform(0, static_cast<double>(rows)));
    const auto b = static_cast<Index>(random->Uniform(0, static_cast<double>(rows)));
    if (a != b) pairs.push_back({a, b});
  }
  auto pattern = std::make_shared<pose_graph::BlockPattern>(rows, pairs);
  pose_graph::BlockMatrix matrix(pattern, d);
  const Index size = static_cast<Index>(d) * d;
  for (Index k = 0; k < pattern->num_blocks(); ++k) {
    for (Index i = 0; i < size; ++i) matrix.block(k)[i] = random->Normal();
  }
  // Diagonally dominant: three times the root of the number of off-diagonal entries would do for random signs.
  for (Index row = 0; row < rows; ++row) {
    for (Index i = 0; i < d; ++i) {
      for (Index k = 0; k < i; ++k)
        matrix.diagonal(row)[i * d + k] = matrix.diagonal(row)[k * d + i] = random->Normal();
      double sum = 1;
      for (std::size_t n = 0; n <= pattern->neighbors(row).size(); ++n) sum += 3.0 * d;
      matrix.diagonal(row)[i * d + i] = sum;
    }
  }
  return matrix;
}

}  // namespace vesta::test
