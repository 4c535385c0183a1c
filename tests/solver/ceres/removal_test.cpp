// SPDX-License-Identifier: Apache-2.0
// Removing and querying blocks. Adapted from Ceres 2.1's test internal/ceres/problem_test.cc.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "solver/evaluate.h"
#include "tests/solver/ceres/twin_problem.h"
#include "tests/support/throws_error.h"

namespace vesta::test {
namespace {

// Residuals of one, two or three blocks: the weighted sum of all their numbers.
Evaluation SumOf(const BlockProblem& problem, const std::vector<int>& blocks) {
  std::vector<int> sizes;
  sizes.reserve(blocks.size());
  for (const int block : blocks) sizes.push_back(problem.parameter_block_size(block));
  return [sizes](const double* const* p, double* r, double** j) {
    r[0] = 0;
    for (std::size_t b = 0; b < sizes.size(); ++b) {
      for (int i = 0; i < sizes[b]; ++i) {
        const double weight = static_cast<double>(b + 1) + 0.1 * i;
        r[0] += weight * p[b][i];
        if (j != nullptr && j[b] != nullptr) j[b][i] = weight;
      }
    }
    return true;
  };
}

// Blocks y, z, w of sizes 4, 5, 3, and residual blocks of all sets of them.
struct Sets : TwinProblem {
  Sets() {
    for (const int size : {4, 5, 3}) AddBlock(std::vector<double>(static_cast<std::size_t>(size), 0.5 * size));
    for (const std::vector<int>& blocks : {std::vector<int>{0, 1, 2}, {0, 1}, {0, 2}, {1, 2}, {0}, {1}, {2}}) {
      ids.push_back(Add(1, SumOf(ours(), blocks), blocks));
    }
  }
  std::vector<ceres::ResidualBlockId> ids;

  void Remove(Index residual_block) {
    theirs().RemoveResidualBlock(ids[static_cast<std::size_t>(residual_block)]);
    ours().RemoveResidualBlock(residual_block);
  }
  void RemoveBlock(int block) {
    theirs().RemoveParameterBlock(values(block));
    ours().RemoveParameterBlock(block);
  }
  // Compares the queries, the costs and a solve.
  void ExpectSame() {
    ASSERT_EQ(ours().num_parameter_blocks(), theirs().NumParameterBlocks());
    ASSERT_EQ(ours().num_residual_blocks(), theirs().NumResidualBlocks());
    std::vector<double*> blocks, expected;
    theirs().GetParameterBlocks(&blocks);
    for (const int block : ours().parameter_blocks()) {
      EXPECT_EQ(std::count(blocks.begin(), blocks.end(), values(block)), 1);
      std::vector<ceres::ResidualBlockId> users;
      theirs().GetResidualBlocksForParameterBlock(values(block), &users);
      const std::vector<Index> of = ours().residual_blocks_of(block);
      ASSERT_EQ(of.size(), users.size());
      for (const Index k : of) {
        EXPECT_EQ(std::count(users.begin(), users.end(), ids[static_cast<std::size_t>(k)]), 1);
      }
    }
    for (const Index k : ours().residual_blocks()) {
      theirs().GetParameterBlocksForResidualBlock(ids[static_cast<std::size_t>(k)], &expected);
      const std::span<const int> of = ours().parameter_blocks_of(k);
      ASSERT_EQ(of.size(), expected.size());
      for (std::size_t i = 0; i < of.size(); ++i) EXPECT_EQ(values(of[i]), expected[i]);
    }
    const std::vector<double> x = this->x();
    double cost = 0;
    theirs().Evaluate({}, &cost, nullptr, nullptr, nullptr);
    EXPECT_NEAR(ours().Cost(View(x)), cost, 1e-14 * cost);
    EXPECT_NEAR(Evaluate(ours(), View(x)).cost, cost, 1e-14 * cost);
  }
};

TEST(CeresCasesProblem, ResidualBlocksAreRemoved) {
  Sets sets;
  sets.ExpectSame();
  for (const Index k : {6, 0, 3, 5}) {
    sets.Remove(k);
    EXPECT_FALSE(sets.ours().has_residual_block(k));
    sets.ExpectSame();
  }
  EXPECT_THAT([&] { sets.ours().RemoveResidualBlock(6); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { sets.ours().RemoveResidualBlock(7); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { sets.ours().cost_function(6); }, ThrowsError(kBadArgument));
}

TEST(CeresCasesProblem, ParameterBlocksAreRemovedWithTheirResidualBlocks) {
  Sets sets;
  sets.RemoveBlock(2);
  EXPECT_EQ(sets.ours().num_residual_blocks(), 3);
  EXPECT_FALSE(sets.ours().has_parameter_block(2));
  sets.ExpectSame();
  EXPECT_THAT([&] { sets.ours().parameter_block_size(2); }, ThrowsError(kBadArgument));
  EXPECT_THAT([&] { sets.ours().RemoveParameterBlock(2); }, ThrowsError(kBadArgument));
  sets.RemoveBlock(0);
  sets.ExpectSame();
  std::vector<double> x = sets.x();
  const LmSummary summary = SolveLm(sets.ours(), x);
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_LE(summary.final_cost, 1e-12 * summary.initial_cost);
  sets.RemoveBlock(1);
  sets.ExpectSame();
  EXPECT_EQ(sets.ours().num_tangent(), 0);
}

}  // namespace
}  // namespace vesta::test
