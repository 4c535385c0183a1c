// SPDX-License-Identifier: Apache-2.0
#include "solver/distributed/part_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kernels/core/check.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

using testing::ElementsAre;

std::vector<double> Iota(Index n) {
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) values.push_back(static_cast<double>(i));
  return values;
}

TEST(PartMap, WithoutSegmentsIsTheWhole) {
  const PartMap map({}, 5, 5, "parameters");
  EXPECT_TRUE(map.is_identity());
  EXPECT_TRUE(map.support().IsAll(5));
}

TEST(PartMap, TakesAndOrders) {
  // The first two entries of the part are entries 6 and 7 of the whole, its last one is entry 2.
  const PartMap map({{0, 6, 2}, {2, 2, 1}}, 3, 9, "parameters");
  EXPECT_FALSE(map.is_compact());
  EXPECT_EQ(map.support(), Support({{2, 3}, {6, 8}}));
  const std::vector<double> whole = Iota(9);
  std::vector<double> local(3), compact(3);
  map.Take<double>({whole.data(), 9}, {local.data(), 3});
  EXPECT_THAT(local, ElementsAre(6, 7, 2));
  map.MakeCompact<double>({local.data(), 3}, {compact.data(), 3});
  EXPECT_THAT(compact, ElementsAre(2, 6, 7));
  EXPECT_TRUE(PartMap({{0, 1, 2}, {2, 5, 1}}, 3, 9, "parameters").is_compact());
}

TEST(PartMap, RefusesSegmentsThatDoNotFit) {
  const auto make = [](const std::vector<PartSegment>& segments) {
    return [segments] { PartMap(segments, 3, 9, "parameters"); };
  };
  EXPECT_THAT(make({}), ThrowsError(kBadArgument, "3", "9"));
  EXPECT_THAT(make({{0, 7, 3}}), ThrowsError(kBadArgument, "7", "9"));
  EXPECT_THAT(make({{0, 0, 2}}), ThrowsError(kBadArgument, "2", "3"));
  EXPECT_THAT(make({{0, 0, 2}, {1, 5, 1}}), ThrowsError(kBadArgument));
  EXPECT_THAT(make({{0, 0, 2}, {2, 1, 1}}), ThrowsError(kBadArgument));
}

TEST(PartMap, BlocksOfThePartAreBlocksOfTheWhole) {
  // The whole has two consecutive blocks of size 2, then three of size 1. The part has the second of size 2 and the
  // last two of size 1.
  const std::vector<BlockGroup> whole{{2, 2, 0, 1, 2}, {1, 3, 4}}, part{{2, 1, 0, 1, 2}, {1, 2, 2}};
  const PartMap tangent({{0, 2, 2}, {2, 5, 2}}, 4, 7, "entries");
  const PartMap map(BlockSegments(part, whole, tangent), 5, 9, "values");
  const std::vector<double> values = Iota(9);
  std::vector<double> local(5);
  map.Take<double>({values.data(), 9}, {local.data(), 5});
  // Packed triangles with the block index running fastest: (0,0) (1,0) (1,1) of block 1 are 1, 3, 5; blocks of size 1
  // start at 6.
  EXPECT_THAT(local, ElementsAre(1, 3, 5, 7, 8));
  EXPECT_THAT(
      [&] {
        BlockSegments({{2, 1, 0, 1, 2}}, whole, PartMap({{0, 1, 2}}, 2, 7, "entries"));
      },
      ThrowsError(kBadArgument));
}

}  // namespace
}  // namespace vesta
