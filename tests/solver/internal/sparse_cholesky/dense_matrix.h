// SPDX-License-Identifier: Apache-2.0
// Block-sparse matrices for tests, and their dense forms.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <vector>

#include "solver/internal/sparse_cholesky/block_matrix.h"
#include "tests/support/dense_reference.h"
#include "tests/support/random.h"

namespace vesta::test {

inline Eigen::VectorXd Vector(const std::vector<double>& v) {
  return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

inline Eigen::MatrixXd Dense(const BlockMatrix& matrix) {
  using Block = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  const BlockPattern& pattern = matrix.pattern();
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(matrix.size(), matrix.size());
  for (Index row = 0; row < pattern.num_rows(); ++row) {
    const Index d = pattern.size(row), at = pattern.offset(row);
    dense.block(at, at, d, d) = Block(matrix.diagonal(row), d, d);
    for (const auto& neighbor : pattern.neighbors(row)) {
      if (neighbor.row > row) continue;
      const Index other = pattern.size(neighbor.row), other_at = pattern.offset(neighbor.row);
      const Block block(matrix.block(neighbor.block), d, other);
      dense.block(at, other_at, d, other) = block;
      dense.block(other_at, at, other, d) = block.transpose();
    }
  }
  return dense;
}

// Sizes of `rows` rows: the given ones, repeated cyclically.
inline std::vector<int> Sizes(Index rows, const std::vector<int>& repeated) {
  std::vector<int> sizes;
  for (std::size_t row = 0; row < static_cast<std::size_t>(rows); ++row) {
    sizes.push_back(repeated[row % repeated.size()]);
  }
  return sizes;
}

// Random values on a pattern, positive definite by diagonal dominance.
inline BlockMatrix RandomValues(const std::shared_ptr<const BlockPattern>& pattern, Random* random) {
  BlockMatrix matrix(pattern);
  for (Index row = 0; row < pattern->num_rows(); ++row) {
    const Index d = pattern->size(row);
    double dominant = 3.0 * static_cast<double>(d) + 1;
    for (const auto& [other, block] : pattern->neighbors(row)) {
      dominant += 3.0 * pattern->size(other);
      if (other > row) continue;
      for (Index i = 0; i < d * pattern->size(other); ++i) matrix.block(block)[i] = random->Normal();
    }
    for (Index i = 0; i < d; ++i) {
      for (Index k = 0; k < i; ++k)
        matrix.diagonal(row)[i * d + k] = matrix.diagonal(row)[k * d + i] = random->Normal();
      matrix.diagonal(row)[i * d + i] = dominant;
    }
  }
  return matrix;
}

// A matrix with num_pairs random pairs of rows; repeated pairs count once.
inline BlockMatrix RandomMatrix(const std::vector<int>& sizes, Index num_pairs, Random* random) {
  const auto rows = static_cast<double>(sizes.size());
  std::vector<BlockPattern::Pair> pairs;
  while (static_cast<Index>(pairs.size()) < num_pairs) {
    const auto a = static_cast<Index>(random->Uniform(0, rows)), b = static_cast<Index>(random->Uniform(0, rows));
    if (a != b) pairs.push_back({a, b});
  }
  return RandomValues(std::make_shared<BlockPattern>(sizes, pairs), random);
}

// A matrix on a square grid in which each row is joined to its neighbours: large fronts on several levels.
inline BlockMatrix GridMatrix(Index side, const std::vector<int>& repeated, Random* random) {
  std::vector<BlockPattern::Pair> pairs;
  for (Index i = 0; i < side * side; ++i) {
    if (i % side > 0) pairs.push_back({i, i - 1});
    if (i >= side) pairs.push_back({i, i - side});
  }
  return RandomValues(std::make_shared<BlockPattern>(Sizes(side * side, repeated), pairs), random);
}

}  // namespace vesta::test
