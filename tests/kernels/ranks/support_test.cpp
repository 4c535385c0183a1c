// SPDX-License-Identifier: Apache-2.0
#include "kernels/ranks/support.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "kernels/core/buffer.h"

namespace vesta {
namespace {

using testing::ElementsAre;

TEST(Support, MergesAdjacentAndOverlappingRanges) {
  const Support support({{5, 7}, {0, 2}, {7, 9}, {1, 3}, {4, 4}});
  EXPECT_THAT(support.ranges(), ElementsAre(EntryRange{0, 3}, EntryRange{5, 9}));
  EXPECT_EQ(support.size(), 7);
  EXPECT_TRUE(Support::All(4).IsAll(4));
  EXPECT_EQ(Support().size(), 0);
}

TEST(Support, CountsAndIntersects) {
  const Support support({{0, 3}, {5, 9}});
  EXPECT_EQ(support.CountBefore(0), 0);
  EXPECT_EQ(support.CountBefore(4), 3);
  EXPECT_EQ(support.CountBefore(6), 4);
  EXPECT_EQ(support.CountBefore(100), 7);
  EXPECT_EQ(Intersection(support, Support({{2, 6}})), Support({{2, 3}, {5, 6}}));
  EXPECT_EQ(Union(support, Support({{2, 5}, {20, 21}})), Support({{0, 9}, {20, 21}}));
}

HostBuffer<double> Buffer(std::initializer_list<double> values) {
  HostBuffer<double> buffer;
  buffer.CopyFrom({values.begin(), static_cast<Index>(values.size())});
  return buffer;
}

TEST(Support, CompactVectorsAddUp) {
  const Support a({{1, 3}, {6, 7}}), b({{2, 4}});
  HostBuffer<double> left = Buffer({1, 2, 3}), spare;
  const HostBuffer<double> two = Buffer({10, 20}), three = Buffer({1, 1, 1});
  AddCompact(a, left, b, two.view(), Union(a, b), spare);
  EXPECT_THAT(std::vector<double>(left.begin(), left.end()), ElementsAre(1, 12, 20, 3));
  AddCompact(Union(a, b), left, a, three.view(), Union(a, b), spare);
  EXPECT_THAT(std::vector<double>(left.begin(), left.end()), ElementsAre(2, 13, 20, 4));
  std::vector<double> whole(8, -1);
  Expand<double>(Union(a, b), left.view(), {whole.data(), 8});
  EXPECT_THAT(whole, ElementsAre(0, 2, 13, 20, 0, 0, 4, 0));
}

TEST(Support, IntersectionAndPositions) {
  const Support a({{0, 10}, {20, 30}, {40, 50}}), b({{5, 22}, {24, 26}, {45, 60}});
  const Support both = Intersection(a, b);
  EXPECT_EQ(both, Support({{5, 10}, {20, 22}, {24, 26}, {45, 50}}));
  EXPECT_EQ(Intersection(b, a), both);
  // Ten entries precede the second range in a compact vector of a, and twenty the third.
  EXPECT_EQ(PositionsIn(b, a), (std::vector<EntryRange>{{5, 12}, {14, 16}, {25, 30}}));
  EXPECT_TRUE(PositionsIn(Support({{10, 20}}), a).empty());
}

}  // namespace
}  // namespace vesta
