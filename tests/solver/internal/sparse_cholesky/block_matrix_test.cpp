// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/sparse_cholesky/block_matrix.h"

#include <gtest/gtest.h>

#include "tests/solver/internal/sparse_cholesky/dense_matrix.h"
#include "tests/support/test_files.h"

namespace vesta {
namespace {

TEST(BlockPattern, NeighborsAscendAndRepeatsAreOneBlock) {
  const BlockPattern::Pair pairs[] = {{3, 1}, {0, 1}, {1, 3}, {2, 0}};
  const std::vector<int> sizes = {2, 5, 1, 2};
  const BlockPattern pattern(sizes, pairs);
  EXPECT_EQ(pattern.num_rows(), 4);
  EXPECT_EQ(pattern.num_blocks(), 3);
  EXPECT_EQ(pattern.num_scalars(), 10);
  EXPECT_EQ(pattern.offset(2), 7);
  EXPECT_EQ(pattern.uniform_size(), 0);
  EXPECT_EQ(pattern.diagonal_value(4), 4 + 25 + 1 + 4);
  EXPECT_EQ(pattern.block_value(3), 10 + 2 + 10);
  EXPECT_EQ(pattern.block_of_pair()[0], pattern.block_of_pair()[2]);
  const std::vector<std::vector<Index>> expected = {{1, 2}, {0, 3}, {0}, {1}};
  for (Index row = 0; row < 4; ++row) {
    std::vector<Index> rows;
    for (const auto& neighbor : pattern.neighbors(row)) rows.push_back(neighbor.row);
    EXPECT_EQ(rows, expected[static_cast<std::size_t>(row)]);
  }
}

TEST(BlockPattern, RefusesPairsOutOfRange) {
  const std::vector<int> sizes = {3, 3}, empty = {3, 0};
  const BlockPattern::Pair same[] = {{1, 1}}, outside[] = {{0, 2}}, negative[] = {{-1, 0}};
  EXPECT_THAT([&] { BlockPattern(sizes, same); }, ThrowsError(kBadArgument, "1", "2"));
  EXPECT_THAT([&] { BlockPattern(sizes, outside); }, ThrowsError(kBadArgument, "2", "0"));
  EXPECT_THAT([&] { BlockPattern(sizes, negative); }, ThrowsError(kBadArgument, "0", "-1", "2"));
  EXPECT_THAT([&] { BlockPattern(empty, {}); }, ThrowsError(kBadArgument, "0"));
}

TEST(BlockMatrix, AppliesAsTheDenseMatrix) {
  for (const auto& repeated : std::vector<std::vector<int>>{{3}, {6}, {1}, {5}, {1, 2, 3}, {6, 3, 11}}) {
    test::Random random(1);
    const BlockMatrix matrix = test::RandomMatrix(test::Sizes(40, repeated), 60, &random);
    const Eigen::MatrixXd dense = test::Dense(matrix);
    EXPECT_EQ((dense - dense.transpose()).norm(), 0);
    const std::vector<double> x = random.NormalVector<double>(static_cast<std::size_t>(matrix.size()));
    std::vector<double> y(x.size());
    matrix.Apply({x.data(), matrix.size()}, {y.data(), matrix.size()});
    const Eigen::VectorXd expected = dense * test::Vector(x);
    EXPECT_LE((test::Vector(y) - expected).norm(), 1e-13 * expected.norm());
  }
}

}  // namespace
}  // namespace vesta
