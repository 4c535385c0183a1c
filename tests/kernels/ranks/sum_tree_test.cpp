#include "kernels/ranks/sum_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace vesta {
namespace {

using testing::ElementsAre;

// The sum of a node by its definition: of its halves.
double SumOfNode(const std::vector<double>& terms, Index begin, Index size) {
  const auto count = static_cast<Index>(terms.size());
  if (size == 1) return terms[static_cast<std::size_t>(begin)];
  const double left = SumOfNode(terms, begin, size / 2);
  return begin + size / 2 < count ? left + SumOfNode(terms, begin + size / 2, size / 2) : left;
}

std::vector<double> Terms(Index count) {
  std::mt19937 random(static_cast<unsigned>(count));
  std::uniform_real_distribution<double> exponent(-20, 20);
  std::vector<double> terms;
  for (Index i = 0; i < count; ++i) terms.push_back(std::exp2(exponent(random)));
  return terms;
}

TEST(SumTree, IsTheSumOfHalves) {
  for (Index count = 1; count <= 70; ++count) {
    const std::vector<double> terms = Terms(count);
    EXPECT_EQ(SumByTree(terms), SumOfNode(terms, 0, 128)) << count << " terms";
  }
  EXPECT_EQ(SumByTree({}), 0);
}

TEST(SumTree, OrderOfAdditionsMatters) {
  // Else the test above could not fail: added from the left these are another number.
  const std::vector<double> terms{1e16, 1, 1, 1};
  EXPECT_EQ(SumByTree(terms), 1e16 + 2);
  EXPECT_EQ(((terms[0] + terms[1]) + terms[2]) + terms[3], 1e16);
}

TEST(SumTree, RunsAreMadeOfFewNodes) {
  EXPECT_THAT(NodesOf(0, 8, 8), ElementsAre(TreeNode{0, 8}));
  EXPECT_THAT(NodesOf(3, 7, 8), ElementsAre(TreeNode{3, 4}, TreeNode{4, 6}, TreeNode{6, 7}));
  EXPECT_THAT(NodesOf(4, 6, 6), ElementsAre(TreeNode{4, 6}));
  EXPECT_THAT(NodesOf(2, 2, 6), ElementsAre());
  for (Index begin = 0; begin < 64; ++begin) {
    for (Index end = begin + 1; end <= 64; ++end) EXPECT_LE(NodesOf(begin, end, 64).size(), 11U);
  }
}

TEST(SumTree, AnyRunsAddUpToTheSameBits) {
  for (const Index count : {1, 5, 37, 64}) {
    const std::vector<double> terms = Terms(count);
    const auto add = [](const TreeNode&, double& a, const TreeNode&, double b) { a += b; };
    for (Index runs = 1; runs <= count; ++runs) {
      TreeSum<double> all(count);
      for (Index k = 0; k < runs; ++k) {
        TreeSum<double> run(count);
        for (Index i = count * k / runs; i < count * (k + 1) / runs; ++i) {
          run.Push({i, i + 1}, terms[static_cast<std::size_t>(i)], add);
        }
        for (const auto& [node, value] : run.nodes()) all.Push(node, value, add);
      }
      EXPECT_EQ(all.whole(), SumByTree(terms)) << count << " terms in " << runs << " runs";
    }
  }
}

TEST(SumTree, SaysWhatIsMissing) {
  TreeSum<double> sum(3);
  const auto add = [](const TreeNode&, double& a, const TreeNode&, double b) { a += b; };
  sum.Push({0, 1}, 1, add);
  EXPECT_THROW(sum.whole(), Error);
  EXPECT_THROW(sum.Push({2, 3}, 1, add), Error);
}

}  // namespace
}  // namespace vesta
