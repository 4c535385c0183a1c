// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/residual_block_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "kernels/core/error.h"
#include "tests/support/throws_error.h"

namespace vesta::residual_blocks_internal {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Seven residual blocks with two of five parameters each. Some parameters are shared; no block uses parameter 3.
constexpr Index kParameters = 5, kBlocks = 7;
const std::vector<Index> kIndex{0, 1, 1, 2, 4, 0, 2, 0, 1, 4, 0, 2, 4, 1};

TEST(ResidualBlockLayout, StridedBatchesTakeTurns) {
  const Layout layout(kParameters, kBlocks, 2, kIndex, 3, BatchSplit::kStrided);
  EXPECT_THAT(layout.blocks(0), ElementsAre(0, 3, 6));
  EXPECT_THAT(layout.blocks(1), ElementsAre(1, 4));
  EXPECT_THAT(layout.blocks(2), ElementsAre(2, 5));
}

TEST(ResidualBlockLayout, ContiguousBatchesAreRuns) {
  const Layout layout(kParameters, kBlocks, 2, kIndex, 3, BatchSplit::kContiguous);
  EXPECT_THAT(layout.blocks(0), ElementsAre(0, 1));
  EXPECT_THAT(layout.blocks(1), ElementsAre(2, 3));
  EXPECT_THAT(layout.blocks(2), ElementsAre(4, 5, 6));
}

TEST(ResidualBlockLayout, MoreBatchesThanBlocksLeaveSomeEmpty) {
  for (const BatchSplit split : {BatchSplit::kStrided, BatchSplit::kContiguous}) {
    const Layout layout(kParameters, 2, 2, {0, 1, 1, 2}, 5, split);
    std::size_t blocks = 0;
    for (int batch = 0; batch < 5; ++batch) {
      blocks += layout.blocks(batch).size();
      EXPECT_EQ(layout.transpose(batch).of(1).empty(), layout.blocks(batch).empty());
    }
    EXPECT_EQ(blocks, 2);
  }
}

// Every entry of the Jacobian appears once, at its parameter, with blocks in order.
TEST(ResidualBlockLayout, TransposeHasEachPlaceUnderItsParameter) {
  for (const BatchSplit split : {BatchSplit::kStrided, BatchSplit::kContiguous}) {
    const Layout layout(kParameters, kBlocks, 2, kIndex, 2, split);
    std::size_t places = 0;
    for (int batch = 0; batch < 2; ++batch) {
      for (Index k = 0; k < kParameters; ++k) {
        Index before = -1;
        for (const Entry& entry : layout.transpose(batch).of(k)) {
          EXPECT_GT(entry.block, before);
          before = entry.block;
          const Index block = layout.blocks(batch)[static_cast<std::size_t>(entry.block)];
          EXPECT_EQ(layout.parameters(block)[entry.column], k);
          ++places;
        }
      }
      EXPECT_THAT(layout.transpose(batch).of(3), IsEmpty()) << "no block uses it";
    }
    EXPECT_EQ(places, kIndex.size());
  }
}

TEST(ResidualBlockLayout, WithoutAnIndexAllReadTheFirstParameters) {
  const Layout layout(4, 3, 2, {}, 1, BatchSplit::kStrided);
  for (Index block = 0; block < 3; ++block) {
    EXPECT_EQ(layout.parameters(block)[0], 0);
    EXPECT_EQ(layout.parameters(block)[1], 1);
  }
  EXPECT_EQ(layout.transpose(0).of(1).size(), 3U);
}

TEST(ResidualBlockLayout, RefusesWhatIsNoLayout) {
  struct Case {
    Index parameters, blocks;
    std::vector<Index> index;
    int batches;
    std::vector<std::string> tokens;
  };
  for (const auto& [parameters, blocks, index, batches, tokens] :
       std::vector<Case>{{5, 2, {0, 1, 2}, 1, {"3", "2"}},
                         {5, 1, {0, 5}, 1, {"5"}},
                         {5, 1, {-1, 0}, 1, {"-1", "5"}},
                         {5, 2, {0, 1, 3, 3}, 1, {"1", "3"}},
                         {1, 1, {}, 1, {"2", "1"}},
                         {5, 1, {0, 1}, 0, {"num_batches", "0"}}}) {
    const auto make = [&] { Layout(parameters, blocks, 2, index, batches, BatchSplit::kStrided); };
    EXPECT_THAT(make, ThrowsErrorWith(kBadArgument, tokens));
  }
}

TEST(ResidualBlockLayout, NamesWhatIsNotFinite) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const Layout layout(3, 2, 2, {0, 1, 2, 0}, 1, BatchSplit::kStrided);
  const std::vector<double> x{7, 8, 9}, good{1, 2}, bad{1, kNan}, jacobian{1, 2, 3, 4}, bad_jacobian{1, 2, 3, kNan};
  const auto words = [&](bool defined, const std::vector<double>& residuals, const std::vector<double>& derivatives) {
    return layout.DescribeNonFinite<double>(1, x, nullptr, defined, residuals, derivatives);
  };
  EXPECT_EQ(words(true, good, jacobian), "");
  EXPECT_THAT(words(false, good, {}), testing::AllOf(HasTokens("1"), testing::Not(HasTokens("nan"))));
  EXPECT_THAT(words(true, bad, {}), HasTokens("1", "nan"));
  EXPECT_THAT(words(true, good, bad_jacobian), HasTokens("1", "0", "nan"));
}

}  // namespace
}  // namespace vesta::residual_blocks_internal
