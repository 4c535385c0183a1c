// SPDX-License-Identifier: Apache-2.0
#include "solver/distributed/shards.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "tests/support/thread_ranks.h"

namespace vesta {
namespace {

using Cpu = CpuBackend<double>;
constexpr int kPieces = 20;

// Two groups stored component by component, as for splats, and one stored block by block, as for points.
std::vector<BlockGroup> Groups() {
  return {{.size = 3, .count = 500, .component_stride = 500},
          {.size = 6, .count = 500, .offset = 1500, .component_stride = 500},
          {.size = 3, .count = 70, .offset = 4500, .block_stride = 3}};
}
constexpr Index kSize = 4500 + 210;

// Deterministic values for all entries.
Cpu::Vector Numbers(int seed) {
  Cpu::Vector values(kSize);
  for (Index k = 0; k < kSize; ++k) values[k] = 0.001 * static_cast<double>((k * (37 + seed)) % 1009) - 0.4;
  return values;
}

TEST(Shards, HoldEachEntryOnceAndGiveItBack) {
  for (const int count : {1, 2, 3, 7}) {
    test::OnThreadRanks(count, [&](Communicator& ranks) {
      const Shards shards(ranks, kSize, Groups(), kPieces);
      Index held = 0;
      for (const Support& entries : shards.of_ranks()) held += entries.size();
      EXPECT_EQ(held, kSize);
      const Cpu::Vector whole = Numbers(0);
      Cpu::Vector shard(shards.own().size()), back(kSize), room;
      shards.Take<double>(whole.view(), shard.view());
      shards.Gather<double>(std::as_const(shard).view(), back.view(), room);
      EXPECT_TRUE(std::ranges::equal(back.view(), whole.view())) << count << " ranks";
    });
  }
}

TEST(Shards, AreAllOfItForOneProcess) {
  SingleRankCommunicator alone;
  const std::vector<BlockGroup> groups = Groups();
  const Shards shards(alone, kSize, groups, kPieces);
  EXPECT_TRUE(shards.is_whole());
  EXPECT_EQ(shards.own(), Support::All(kSize));
  for (std::size_t g = 0; g < shards.groups().size(); ++g) {
    const BlockGroup &whole = groups[g], &own = shards.groups()[g];
    EXPECT_EQ(own.Parameter(whole.count - 1, whole.size - 1), whole.Parameter(whole.count - 1, whole.size - 1));
  }
}

TEST(Shards, BlocksOfAShardAreThoseOfTheWhole) {
  test::OnThreadRanks(3, [](Communicator& ranks) {
    const Shards shards(ranks, kSize, Groups(), kPieces);
    BlockDiagonal<Cpu> whole(kSize, Groups()), own(shards.own().size(), shards.groups());
    const HostSpan<double> values = whole.all_values();
    for (Index k = 0; k < values.size(); ++k) values[k] = static_cast<double>((k * 11) % 17) - 8;
    Index at = 0;
    const std::vector<Support> of_ranks = shards.BlockValuesOfRanks();
    const Support& places = of_ranks[static_cast<std::size_t>(ranks.rank())];
    ASSERT_EQ(places.size(), own.all_values().size());
    for (const EntryRange& range : places.ranges()) {
      for (Index k = range.begin; k < range.end; ++k) own.all_values()[at++] = values[k];
    }
    Cpu::Vector product(kSize), x(shards.own().size()), y(x.size()), expected(x.size());
    const Cpu::Vector v = Numbers(1);
    whole.Apply(v, product);
    shards.Take<double>(std::as_const(product).view(), expected.view());
    shards.Take<double>(v.view(), x.view());
    own.Apply(x, y);
    EXPECT_TRUE(std::ranges::equal(y.view(), expected.view())) << "rank " << ranks.rank();
  });
}

struct Products {
  double dot, weighted;
  friend bool operator==(const Products&, const Products&) = default;
};

Products On(int count) {
  Products result{};
  std::mutex mutex;
  test::OnThreadRanks(count, [&](Communicator& ranks) {
    const Shards shards(ranks, kSize, Groups(), kPieces);
    const ShardProducts<double> products(shards);
    Cpu::Vector v[3];
    for (int k = 0; k < 3; ++k) {
      v[k].Resize(shards.own().size());
      const Cpu::Vector whole = Numbers(k);
      shards.Take<double>(whole.view(), v[k].view());
    }
    double weighted = 0;
    products.WeightedDot(v[2], v[0], v[1], {&weighted});
    const Products mine{products.Dot(v[0], v[1]), weighted};
    const std::lock_guard lock(mutex);
    if (ranks.rank() != 0) return;
    result = mine;
  });
  return result;
}

TEST(ShardProducts, AreTheSameBitsForAnyNumberOfRanks) {
  const Products alone = On(1);
  Cpu backend;
  EXPECT_NEAR(alone.dot, backend.Dot(Numbers(0), Numbers(1)), 1e-10);
  EXPECT_NEAR(alone.weighted, backend.WeightedDot(Numbers(2), Numbers(0), Numbers(1)), 1e-10);
  for (const int count : {2, 3, 7, kPieces}) EXPECT_EQ(On(count), alone) << count << " ranks";
}

TEST(ShardProducts, SeeWhatIsNotFiniteAnywhere) {
  test::OnThreadRanks(3, [](Communicator& ranks) {
    const Shards shards(ranks, kSize, Groups(), kPieces);
    const ShardProducts<double> products(shards);
    Cpu::Vector v(shards.own().size());
    EXPECT_TRUE(products.AllFinite(v));
    if (ranks.rank() == 2) v[3] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(products.AllFinite(v)) << "rank " << ranks.rank();
  });
}

}  // namespace
}  // namespace vesta
