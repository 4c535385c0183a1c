#include "problems/gaussian_splatting/train/agreement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/thread_ranks.h"

namespace vesta::gs {
namespace {

using testing::ElementsAre;

TEST(Agreement, OneAloneDecidesByItself) {
  SoloRank solo;
  for (Ranks* ranks : {static_cast<Ranks*>(nullptr), static_cast<Ranks*>(&solo)}) {
    const Agreement together(ranks);
    EXPECT_TRUE(together.is_alone());
    EXPECT_TRUE(together.OnAny(true));
    EXPECT_FALSE(together.OnAny(false));
    EXPECT_THAT(together.OnEach(true), ElementsAre(true));
    EXPECT_EQ(together.MostOfAll(-3), -3);
    EXPECT_EQ(together.OfFirst(5), 5);
  }
}

TEST(Agreement, SeveralHaveTheSameAnswers) {
  vesta::test::OnThreadRanks(3, [](Ranks& ranks) {
    const Agreement together(&ranks);
    EXPECT_FALSE(together.is_alone());
    EXPECT_TRUE(together.OnAny(ranks.rank() == 2));
    EXPECT_FALSE(together.OnAny(false));
    EXPECT_THAT(together.OnEach(ranks.rank() == 1), ElementsAre(false, true, false));
    EXPECT_EQ(together.MostOfAll(-1 - ranks.rank()), -1);
    EXPECT_EQ(together.OfFirst(10 + ranks.rank()), 10);
  });
}

}  // namespace
}  // namespace vesta::gs
