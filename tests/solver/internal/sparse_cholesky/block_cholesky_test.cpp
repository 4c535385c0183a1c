// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/sparse_cholesky/block_cholesky.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/solver/internal/sparse_cholesky/dense_matrix.h"
#include "tests/support/test_files.h"

namespace vesta {
namespace {

std::shared_ptr<const EliminationPlan> PlanFor(const BlockMatrix& matrix) {
  return std::make_shared<EliminationPlan>(PlanElimination(matrix.pattern()).value());
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
        test::Apply(test::Dense(matrix), test::Vector(y)) + 0.5 * test::Vector(added).cwiseProduct(test::Vector(y));
    worst = std::max(worst, (back - test::Vector(x)).norm() / test::Vector(x).norm());
  }
  return worst;
}

// The block sizes of the rows, repeated cyclically.
class BlockCholeskyOf : public testing::TestWithParam<std::vector<int>> {};

TEST_P(BlockCholeskyOf, SolvesRandomMatrices) {
  test::Random random(1);
  // From no pairs to a full matrix.
  for (const auto& [rows, pairs] : {std::pair<Index, Index>{1, 0}, {7, 0}, {2, 1}, {30, 29}, {30, 300}, {60, 90}}) {
    const BlockMatrix matrix = test::RandomMatrix(test::Sizes(rows, GetParam()), pairs, &random);
    BlockCholesky factor(PlanFor(matrix));
    EXPECT_LE(WorstResidual(matrix, &factor, &random), 1e-13) << rows << " rows, " << pairs << " pairs";
  }
}

TEST_P(BlockCholeskyOf, SolvesAGridWithSeveralLevelsOfFronts) {
  test::Random random(2);
  const BlockMatrix matrix = test::GridMatrix(16, GetParam(), &random);
  const auto plan = PlanFor(matrix);
  EXPECT_GT(plan->subtrees.size(), 1u);
  EXPECT_GT(plan->levels.size(), 1u);
  BlockCholesky factor(plan);
  EXPECT_LE(WorstResidual(matrix, &factor, &random), 1e-13);
}

INSTANTIATE_TEST_SUITE_P(Sizes, BlockCholeskyOf,
                         testing::Values(std::vector<int>{3}, std::vector<int>{6}, std::vector<int>{1},
                                         std::vector<int>{2}, std::vector<int>{7}, std::vector<int>{1, 6, 3},
                                         std::vector<int>{9, 3, 3, 3}, std::vector<int>{4, 1, 1, 13}),
                         [](const auto& tested) {
                           std::string name = "Of";
                           for (const int size : tested.param) name += "_" + std::to_string(size);
                           return name;
                         });

// A plan for blocks of 3 also factorises matrices with other blocks at the same places.
TEST(SparseCholesky, ItsPlanFitsBlocksOfAnotherSize) {
  test::Random random(4);
  const BlockMatrix planned = test::GridMatrix(16, {3}, &random);
  const auto cholesky = SparseCholesky::Plan(planned.pattern(), 1e9);
  for (const int size : {1, 2, 3, 6}) {
    test::Random same(4);
    const BlockMatrix matrix = test::GridMatrix(16, {size}, &same);
    const auto resized = cholesky->ForPattern(planned.pattern(), matrix.pattern());
    ASSERT_NE(resized, nullptr) << size;
    EXPECT_EQ(resized->plan().num_scalars, matrix.size());
    EXPECT_LE(WorstResidual(matrix, resized->Factor().get(), &random), 1e-13) << size;
  }
  const auto fits = [&](const BlockMatrix& other) {
    return cholesky->ForPattern(planned.pattern(), other.pattern()) != nullptr;
  };
  EXPECT_FALSE(fits(test::GridMatrix(15, {3}, &random)));
  EXPECT_FALSE(fits(test::GridMatrix(16, {3, 6}, &random)));
}

TEST(BlockCholesky, TakesUpTheUpdatesOfAStarInWaves) {
  // Many leaves that all touch the same few rows: the updates of all leaves at once would take 90 MiB.
  constexpr Index kLeaves = 1500, kHubs = 12;
  std::vector<int> sizes(static_cast<std::size_t>(kHubs + kLeaves), 3);
  std::vector<BlockPattern::Pair> pairs;
  for (Index hub = 0; hub < kHubs; ++hub) {
    sizes[static_cast<std::size_t>(hub)] = 7;
    for (Index leaf = 0; leaf < kLeaves; ++leaf) pairs.push_back({hub, kHubs + leaf});
  }
  test::Random random(8);
  const BlockMatrix matrix = test::RandomValues(std::make_shared<BlockPattern>(sizes, pairs), &random);
  const auto plan = PlanFor(matrix);
  EXPECT_GT(plan->waves.size(), 1u);
  BlockCholesky factor(plan);
  EXPECT_LE(WorstResidual(matrix, &factor, &random), 1e-13);
}

TEST(EliminationPlan, CoversEachRowOnceAndChildrenComeFirst) {
  test::Random random(3);
  const BlockMatrix matrix = test::GridMatrix(20, {3}, &random);
  const EliminationPlan plan = PlanElimination(matrix.pattern()).value();
  std::vector<Index> order;
  for (const EliminationPlan::Row& row : plan.order) order.push_back(row.original);
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
  EXPECT_EQ(plan.num_scalars, matrix.size());
  for (const EliminationSubtree& subtree : plan.subtrees) {
    for (Index f = subtree.begin; f < subtree.end; ++f) ++seen[static_cast<std::size_t>(f)];
  }
  for (const auto& level : plan.levels) {
    for (const Index f : level) ++seen[static_cast<std::size_t>(f)];
  }
  for (const int times : seen) EXPECT_EQ(times, 1);
  // The natural order of an n x n grid fills n^3 blocks, here 8000 with 9 values each; a good order fills about n^2 log
  // n.
  EXPECT_LT(plan.factor_values, 9 * 6000);
}

TEST(EliminationPlan, CountsADenseMatrixExactly) {
  const std::vector<int> sizes = {2, 3, 1};
  const BlockPattern::Pair pairs[] = {{0, 1}, {0, 2}, {1, 2}};
  const EliminationPlan plan = PlanElimination(BlockPattern(sizes, pairs)).value();
  EXPECT_EQ(plan.factor_values, 21);
  EXPECT_DOUBLE_EQ(plan.multiplications, 36);
}

TEST(EliminationPlan, RefusesWhatIsOverTheLimits) {
  test::Random random(7);
  const BlockMatrix matrix = test::GridMatrix(20, {3, 1, 2}, &random);
  const EliminationPlan plan = PlanElimination(matrix.pattern()).value();
  // The limits apply to the factor before its fronts are merged, which is only slightly smaller.
  EXPECT_TRUE(PlanElimination(matrix.pattern(), {plan.factor_values, plan.multiplications}).has_value());
  EXPECT_FALSE(PlanElimination(matrix.pattern(), {.factor_values = 0.5 * plan.factor_values}).has_value());
  EXPECT_FALSE(PlanElimination(matrix.pattern(), {.multiplications = 0.5 * plan.multiplications}).has_value());
}

TEST(BlockCholesky, IndefiniteAndSingularMatricesGiveAFiniteDefinitePreconditioner) {
  test::Random random(4);
  BlockMatrix matrix = test::RandomMatrix(test::Sizes(20, {3}), 40, &random);
  matrix.diagonal(7)[4] = -5;
  for (Index i = 0; i < 9; ++i) matrix.diagonal(11)[i] = 0;
  for (const auto& neighbor : matrix.pattern().neighbors(11)) {
    for (Index i = 0; i < 9; ++i) matrix.block(neighbor.block)[i] = 0;
  }
  BlockCholesky factor(PlanFor(matrix));
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
  const BlockMatrix small = test::RandomMatrix({3, 3, 3}, 2, &random);
  const BlockMatrix large = test::RandomMatrix({3, 3, 3, 3}, 2, &random);
  BlockCholesky factor(PlanFor(small));
  const std::vector<double> added(12, 0.0);
  EXPECT_THAT([&] { factor.Factorize(large, 0, {added.data(), 12}); }, ThrowsError(kBadArgument, "12"));
}

}  // namespace
}  // namespace vesta
