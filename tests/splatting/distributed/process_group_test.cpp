// SPDX-License-Identifier: Apache-2.0
#include "splatting/distributed/process_group.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/support/thread_ranks.h"

namespace vesta::gs {
namespace {

using testing::ElementsAre;

TEST(ProcessGroup, OneAloneDecidesByItself) {
  SingleRankCommunicator solo;
  for (Communicator* ranks : {static_cast<Communicator*>(nullptr), static_cast<Communicator*>(&solo)}) {
    const ProcessGroup processes(ranks);
    EXPECT_TRUE(processes.is_alone());
    EXPECT_TRUE(processes.is_first());
    EXPECT_TRUE(processes.OnAny(true));
    EXPECT_FALSE(processes.OnAny(false));
    EXPECT_EQ(processes.OfFirst(5), 5);
    EXPECT_THAT(processes.Gather(std::vector<int>{1, 2}), ElementsAre(1, 2));
    EXPECT_EQ(processes.OwnShare(7).size(), 7);
  }
}

TEST(ProcessGroup, SeveralHaveTheSameAnswers) {
  vesta::test::OnThreadRanks(3, [](Communicator& ranks) {
    const ProcessGroup processes(&ranks);
    EXPECT_FALSE(processes.is_alone());
    EXPECT_EQ(processes.is_first(), ranks.rank() == 0);
    EXPECT_TRUE(processes.OnAny(ranks.rank() == 2));
    EXPECT_FALSE(processes.OnAny(false));
    EXPECT_EQ(processes.OfFirst(10 + ranks.rank()), 10);
    EXPECT_THAT(processes.Gather(std::vector<int>(static_cast<std::size_t>(ranks.rank()), ranks.rank())),
                ElementsAre(1, 2, 2));
  });
}

TEST(ProcessGroup, SharesAreAllOfTheWork) {
  for (const int count : {2, 3, 5}) {
    vesta::test::OnThreadRanks(3, [count](Communicator& ranks) {
      const ProcessGroup processes(&ranks);
      std::vector<int> mine;
      const Share own = processes.OwnShare(count);
      for (auto k = own.begin; k < own.end; ++k) mine.push_back(static_cast<int>(k));
      const std::vector<int> all = processes.Gather(mine);
      ASSERT_EQ(static_cast<int>(all.size()), count);
      for (int k = 0; k < count; ++k) EXPECT_EQ(all[static_cast<std::size_t>(k)], k);
    });
  }
}

}  // namespace
}  // namespace vesta::gs
