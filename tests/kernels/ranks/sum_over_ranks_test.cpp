// SPDX-License-Identifier: Apache-2.0
#include "kernels/ranks/sum_over_ranks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>
#include <random>

#include "kernels/core/check.h"
#include "tests/support/thread_ranks.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

constexpr Index kTerms = 23, kSize = 101;

// Non-zero at entries that all terms share, and at its own.
Support SupportOf(Index term) { return Support({{3, 11}, {20 + 3 * term, 22 + 3 * term}, {40, 40 + term}}); }

std::vector<float> Term(Index term) {
  std::mt19937 random(static_cast<unsigned>(term));
  std::uniform_real_distribution<float> entry(-1, 1);
  std::vector<float> values(static_cast<std::size_t>(SupportOf(term).size()));
  for (float& value : values) value = entry(random) * static_cast<float>(1 << (term % 12));
  return values;
}

// By definition, entry by entry.
std::vector<float> Expected() {
  std::vector<std::vector<float>> dense;
  dense.reserve(kTerms);
  for (Index term = 0; term < kTerms; ++term) {
    std::vector<float> whole(kSize);
    const std::vector<float> compact = Term(term);
    Expand<float>(SupportOf(term), {compact.data(), static_cast<Index>(compact.size())}, {whole.data(), kSize});
    dense.push_back(whole);
  }
  std::vector<float> sum;
  sum.reserve(kSize);
  for (std::size_t entry = 0; entry < kSize; ++entry) {
    TreeSum<float> tree(kTerms);
    for (Index term = 0; term < kTerms; ++term) {
      tree.Push({term, term + 1}, dense[static_cast<std::size_t>(term)][entry],
                [](const TreeNode&, float& a, const TreeNode&, float b) { a += b; });
    }
    sum.push_back(tree.TakeWhole());
  }
  return sum;
}

std::vector<Support> SupportsOf(const TreeNode& terms) {
  std::vector<Support> supports;
  supports.reserve(static_cast<std::size_t>(terms.end - terms.begin));
  for (Index term = terms.begin; term < terms.end; ++term) supports.push_back(SupportOf(term));
  return supports;
}

void MakeTerm(Index term, HostSpan<float> to) {
  const std::vector<float> values = Term(term);
  std::copy(values.begin(), values.end(), to.begin());
}

TEST(SumOverRanks, IsTheSameBitsForAnyNumberOfRanks) {
  const std::vector<float> expected = Expected();
  for (const int count : {1, 2, 3, 4, 8, 23}) {
    test::OnThreadRanks(count, [&](Communicator& ranks) {
      SumOverRanks<float> sum(ranks, kTerms, kSize, SupportsOf(TermsOf(kTerms, ranks, ranks.rank())));
      for (int again = 0; again < 2; ++again) {
        std::vector<float> out(kSize, -1.0F);
        sum.Sum(MakeTerm, {out.data(), kSize});
        EXPECT_EQ(out, expected) << count << " ranks";
      }
    });
  }
}

// Runs of five entries, finished by the ranks in turn.
std::vector<Support> Scattered(int count) {
  std::vector<std::vector<EntryRange>> ranges(static_cast<std::size_t>(count));
  for (Index begin = 0; begin < kSize; begin += 5) {
    ranges[static_cast<std::size_t>(begin / 5 % count)].push_back({begin, std::min(begin + 5, kSize)});
  }
  return {ranges.begin(), ranges.end()};
}

TEST(SumOverRanks, GivesEachRankItsShare) {
  const std::vector<float> expected = Expected();
  for (const int count : {1, 2, 3, 8}) {
    test::OnThreadRanks(count, [&](Communicator& ranks) {
      const std::vector<Support> finished = Scattered(count);
      SumOverRanks<float> sum(ranks, kTerms, kSize, SupportsOf(TermsOf(kTerms, ranks, ranks.rank())), finished);
      const Support& mine = finished[static_cast<std::size_t>(ranks.rank())];
      std::vector<float> share(static_cast<std::size_t>(mine.size()), -1.0F), whole;
      const std::int64_t before = ranks.traffic().bytes;
      sum.SumShare(MakeTerm, {share.data(), mine.size()});
      EXPECT_EQ(ranks.traffic().bytes - before, 4 * sum.plan().ReceivedValuesOfShare(ranks.rank()));
      for (const EntryRange& range : mine.ranges()) {
        whole.insert(whole.end(), expected.begin() + range.begin, expected.begin() + range.end);
      }
      EXPECT_EQ(share, whole) << count << " ranks";
    });
  }
}

TEST(SumOverRanks, ReceivesAsManyValuesAsPlanned) {
  test::OnThreadRanks(3, [&](Communicator& ranks) {
    SumOverRanks<float> sum(ranks, kTerms, kSize, SupportsOf(TermsOf(kTerms, ranks, ranks.rank())));
    const RankTraffic before = ranks.traffic();
    std::vector<float> out(kSize);
    sum.Sum(MakeTerm, {out.data(), kSize});
    const Index all = sum.plan().ReceivedValues(ranks.rank());
    EXPECT_EQ(ranks.traffic().bytes - before.bytes, 4 * all);
    EXPECT_EQ(ranks.traffic().gathered - before.gathered, 4 * (all - sum.plan().ReceivedValuesOfShare(ranks.rank())));
  });
}

TEST(SumOverRanks, OfDenseTermsTransfersTheBytesOfAnAllReduce) {
  constexpr Index kDense = 1 << 12;
  test::OnThreadRanks(4, [&](Communicator& ranks) {
    SumOverRanks<float> sum(ranks, 64, kDense, std::vector<Support>(16, Support::All(kDense)));
    EXPECT_EQ(sum.plan().ReceivedValues(ranks.rank()), 2 * kDense * 3 / 4);
  });
}

TEST(SumOverRanks, RefusesMoreRanksThanTerms) {
  const auto sum = [] {
    test::OnThreadRanks(3, [](Communicator& ranks) { SumOverRanks<float> refused(ranks, 2, kSize, {}); });
  };
  EXPECT_THAT(sum, ThrowsError(kBadArgument, "3", "2"));
}

TEST(Communicator, ReportsTheFailureOfAnotherRank) {
  std::mutex mutex;
  std::vector<std::string> words;
  const auto run = [&] {
    test::OnThreadRanks(3, [&](Communicator& ranks) {
      try {
        if (ranks.rank() == 1) Fail(kOutOfMemory, "no room");
        OnAnyRank(ranks, false);
      } catch (const Error& error) {
        const std::lock_guard lock(mutex);
        words.emplace_back(error.what());
        throw;
      }
    });
  };
  EXPECT_THROW(run(), Error);
  EXPECT_THAT(words, testing::UnorderedElementsAre("no room", "process 1 of 3: no room", "process 1 of 3: no room"));
}

TEST(Communicator, GathersAnyNumberOfValues) {
  test::OnThreadRanks(4, [](Communicator& ranks) {
    const std::vector<int> mine(static_cast<std::size_t>(ranks.rank()), ranks.rank());
    EXPECT_THAT(GatherValues(ranks, mine), testing::ElementsAre(1, 2, 2, 3, 3, 3));
    EXPECT_THAT(GatherStrings(ranks, std::string(static_cast<std::size_t>(ranks.rank()), 'a')),
                testing::ElementsAre("", "a", "aa", "aaa"));
    EXPECT_TRUE(OnAnyRank(ranks, ranks.rank() == 2));
    EXPECT_FALSE(OnAnyRank(ranks, false));
  });
}

}  // namespace
}  // namespace vesta
