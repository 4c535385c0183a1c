// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/core/check.h"
#include "solver/covariance.h"
#include "solver/levenberg_marquardt.h"
#include "tests/solver/internal/sparse_cholesky/block_chain.h"

namespace vesta {
namespace {

using test::BlockChain;

TEST(BlockCovariance, BlocksAreThoseOfTheDenseOne) {
  BlockChain chain(20);
  CpuBackend<double> backend;
  SolveLm<CpuBackend<double>>(LmOptions(), backend, chain.problem, chain.x.view());
  const Covariance dense = EstimateCovariance(chain.problem, chain.x);
  ASSERT_EQ(dense.rank, dense.size);
  const std::vector<std::pair<int, int>> pairs = {{chain.turns[5], chain.turns[5]},
                                                  {chain.shifts[19], chain.turns[3]},
                                                  {chain.scales[1], chain.shifts[19]},
                                                  {chain.turns[0], chain.shifts[2]}};
  const BlockCovariance chosen = EstimateBlockCovariance(chain.problem, chain.x, pairs);
  EXPECT_EQ(chosen.num_singular, 0);
  ASSERT_EQ(chosen.blocks.size(), pairs.size());
  EXPECT_EQ(chosen.blocks.back().values.size(), 0U) << "a constant block has no covariance";
  for (std::size_t k = 0; k + 1 < pairs.size(); ++k) {
    const BlockCovariance::Block& block = chosen.blocks[k];
    const auto row0 = static_cast<int>(chain.problem.tangent_offset(pairs[k].first));
    const auto col0 = static_cast<int>(chain.problem.tangent_offset(pairs[k].second));
    ASSERT_EQ(block.rows, chain.problem.tangent_size(pairs[k].first));
    ASSERT_EQ(block.cols, chain.problem.tangent_size(pairs[k].second));
    for (int r = 0; r < block.rows; ++r) {
      for (int c = 0; c < block.cols; ++c) {
        const double scale = std::sqrt(dense(row0 + r, row0 + r) * dense(col0 + c, col0 + c));
        EXPECT_NEAR(block(r, c), dense(row0 + r, col0 + c), 1e-9 * scale) << k;
      }
    }
  }
}

TEST(BlockCovariance, IsForProblemsWhoseDenseOneDoesNotFit) {
  BlockChain chain(2000);
  EXPECT_EQ(chain.problem.num_tangent(), 1999 * 6 + 400);
  const std::pair<int, int> pair(chain.shifts[1999], chain.shifts[1999]);
  EXPECT_THROW(EstimateCovariance(chain.problem, chain.x), Error);
  // The end of a chain is less certain than its start.
  const std::pair<int, int> both[] = {pair, {chain.shifts[2], chain.shifts[2]}};
  const BlockCovariance covariance = EstimateBlockCovariance(chain.problem, chain.x, both);
  ASSERT_EQ(covariance.blocks.size(), 2U);
  EXPECT_GT(covariance.blocks[0](1, 1), 100 * covariance.blocks[1](1, 1));
  EXPECT_GT(covariance.blocks[1](1, 1), 0);
}

TEST(BlockCovariance, TellsOfDirectionsWithoutInformation) {
  BlockChain chain(6);
  chain.problem.SetConstant(chain.turns[0], false);
  chain.problem.SetConstant(chain.shifts[0], false);
  const std::pair<int, int> pair(chain.shifts[3], chain.shifts[3]);
  const BlockCovariance covariance = EstimateBlockCovariance(chain.problem, chain.x, std::span(&pair, 1));
  EXPECT_GE(covariance.num_singular, 1);
  EXPECT_TRUE(covariance.blocks.empty());
  EXPECT_THROW(EstimateBlockCovariance(chain.problem, chain.x.view().subspan(1, 3), std::span(&pair, 1)), Error);
}

}  // namespace
}  // namespace vesta
