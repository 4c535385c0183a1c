#include "problems/pose_graph/block_cholesky.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/problems/pose_graph/dense_matrix.h"
#include "tests/support/test_files.h"

namespace vesta::pose_graph {
namespace {

std::shared_ptr<const EliminationPlan> PlanFor(const BlockMatrix& matrix) {
  return std::make_shared<EliminationPlan>(PlanElimination(matrix.pattern()));
}

// Largest relative residual of a few solves with (matrix + 0.5 diag(added)).
double WorstResidual(const BlockMatrix& matrix, BlockCholesky* factor, test::Random* random) {
  const auto n = static_cast<std::size_t>(matrix.size());
  double worst = 0;
  for (int repeat = 0; repeat < 2; ++repeat) {
    std::vector<double> added(n), y(n);
    for (double& a : added) a = random->Uniform(0, 2);
    EXPECT_EQ(factor->Factorize(matrix, 0.5, {added.data(), matrix.size()}), 0);
    const std::vector<double> x = random->NormalVector<double>(n);
    factor->Solve({x.data(), matrix.size()}, {y.data(), matrix.size()});
    const Eigen::VectorXd back =
        test::Dense(matrix) * test::Vector(y) + 0.5 * test::Vector(added).cwiseProduct(test::Vector(y));
    worst = std::max(worst, (back - test::Vector(x)).norm() / test::Vector(x).norm());
  }
  return worst;
}

TEST(BlockCholesky, SolvesRandomMatrices) {
  test::Random random(1);
  for (const int d : {3, 6}) {
    // From no pairs at all to a full matrix.
    for (const auto& [rows, pairs] : {std::pair<Index, Index>{1, 0}, {7, 0}, {2, 1}, {30, 29}, {30, 300}, {60, 90}}) {
      const BlockMatrix matrix = test::RandomMatrix(rows, pairs, d, &random);
      BlockCholesky factor(PlanFor(matrix), d);
      EXPECT_LE(WorstResidual(matrix, &factor, &random), 1e-13) << rows << " rows, " << pairs << " pairs";
    }
  }
}

// Rows of a square grid, each joined to its neighbours: large fronts, several levels of them.
BlockMatrix GridMatrix(Index side, int d, test::Random* random) {
  std::vector<BlockPattern::Pair> pairs;
  for (Index i = 0; i < side * side; ++i) {
    if (i % side > 0) pairs.push_back({i, i - 1});
    if (i >= side) pairs.push_back({i, i - side});
  }
  BlockMatrix matrix(std::make_shared<BlockPattern>(side * side, pairs), d);
  for (Index k = 0; k < matrix.pattern().num_blocks(); ++k) {
    for (Index i = 0; i < d * d; ++i) matrix.block(k)[i] = random->Uniform(-1, 1);
  }
  for (Index row = 0; row < side * side; ++row) {
    for (Index i = 0; i < d; ++i) matrix.diagonal(row)[i * d + i] = 4.0 * d;
  }
  return matrix;
}

TEST(BlockCholesky, SolvesAGridWithSeveralLevelsOfFronts) {
  test::Random random(2);
  const BlockMatrix matrix = GridMatrix(16, 6, &random);
  const auto plan = PlanFor(matrix);
  EXPECT_GT(plan->subtrees.size(), 1u);
  EXPECT_GT(plan->levels.size(), 1u);
  BlockCholesky factor(plan, 6);
  EXPECT_LE(WorstResidual(matrix, &factor, &random), 1e-13);
}

TEST(EliminationPlan, CoversEachRowOnceAndChildrenComeFirst) {
  test::Random random(3);
  const BlockMatrix matrix = GridMatrix(20, 3, &random);
  const EliminationPlan plan = PlanElimination(matrix.pattern());
  std::vector<Index> order = plan.order;
  std::sort(order.begin(), order.end());
  for (std::size_t k = 0; k < order.size(); ++k) EXPECT_EQ(order[k], static_cast<Index>(k));
  Index next = 0;
  std::vector<int> seen(plan.fronts.size(), 0);
  for (std::size_t f = 0; f < plan.fronts.size(); ++f) {
    EXPECT_EQ(plan.fronts[f].first, next);
    next += plan.fronts[f].pivots;
    for (const Index child : plan.fronts[f].children) EXPECT_LT(child, static_cast<Index>(f));
  }
  EXPECT_EQ(next, matrix.pattern().num_rows());
  for (const EliminationSubtree& subtree : plan.subtrees) {
    for (Index f = subtree.begin; f < subtree.end; ++f) ++seen[static_cast<std::size_t>(f)];
  }
  for (const auto& level : plan.levels) {
    for (const Index f : level) ++seen[static_cast<std::size_t>(f)];
  }
  for (const int times : seen) EXPECT_EQ(times, 1);
  // The natural order of a grid of side n fills n^3 blocks, here 8000; a good one of the order of n^2 log n.
  EXPECT_LT(plan.factor_blocks, 6000);
}

TEST(BlockCholesky, IndefiniteAndSingularMatricesGiveAFiniteDefinitePreconditioner) {
  test::Random random(4);
  BlockMatrix matrix = test::RandomMatrix(20, 40, 3, &random);
  matrix.diagonal(7)[4] = -5;
  for (Index i = 0; i < 9; ++i) matrix.diagonal(11)[i] = 0;
  for (const auto& neighbor : matrix.pattern().neighbors(11)) {
    for (Index i = 0; i < 9; ++i) matrix.block(neighbor.block)[i] = 0;
  }
  BlockCholesky factor(PlanFor(matrix), 3);
  const std::vector<double> added(static_cast<std::size_t>(matrix.size()), 0.0);
  EXPECT_GE(factor.Factorize(matrix, 0, {added.data(), matrix.size()}), 4);
  const std::vector<double> x = random.NormalVector<double>(added.size());
  std::vector<double> y(x.size());
  factor.Solve({x.data(), matrix.size()}, {y.data(), matrix.size()});
  for (const double value : y) EXPECT_TRUE(std::isfinite(value));
  EXPECT_GT(test::Vector(x).dot(test::Vector(y)), 0);
}

TEST(BlockCholesky, RefusesAMatrixOfAnotherSize) {
  test::Random random(5);
  const BlockMatrix small = test::RandomMatrix(3, 2, 3, &random), large = test::RandomMatrix(4, 2, 3, &random);
  BlockCholesky factor(PlanFor(small), 3);
  const std::vector<double> added(12, 0.0);
  ExpectError([&] { factor.Factorize(large, 0, {added.data(), 12}); }, "a matrix of 12 rows");
}

}  // namespace
}  // namespace vesta::pose_graph
