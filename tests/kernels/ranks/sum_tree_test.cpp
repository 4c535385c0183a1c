// SPDX-License-Identifier: Apache-2.0
#include "kernels/ranks/sum_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace vesta {
namespace {

using testing::ElementsAre;

// By definition: the sum of its halves.
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
  terms.reserve(static_cast<std::size_t>(count));
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

TEST(SumTree, RangesConsistOfFewNodes) {
  EXPECT_THAT(NodesOf(0, 8, 8), ElementsAre(TreeNode{0, 8}));
  EXPECT_THAT(NodesOf(3, 7, 8), ElementsAre(TreeNode{3, 4}, TreeNode{4, 6}, TreeNode{6, 7}));
  EXPECT_THAT(NodesOf(4, 6, 6), ElementsAre(TreeNode{4, 6}));
  EXPECT_THAT(NodesOf(2, 2, 6), ElementsAre());
  for (Index begin = 0; begin < 64; ++begin) {
    for (Index end = begin + 1; end <= 64; ++end) EXPECT_LE(NodesOf(begin, end, 64).size(), 11U);
  }
}

TEST(SumTree, AnyRangesGiveBitIdenticalSums) {
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
        for (const auto& [node, value] : run.parts()) all.Push(node, value, add);
      }
      EXPECT_EQ(all.TakeWhole(), SumByTree(terms)) << count << " terms in " << runs << " runs";
    }
  }
}

// Records the order of additions.
void Join(const TreeNode&, std::string& left, const TreeNode&, const std::string& right) {
  left = "(" + left + "+" + right + ")";
}
std::string WordsOf(Index terms, const std::vector<Index>& order) {
  TreeSum<std::string> tree(terms);
  for (const Index k : order) {
    EXPECT_FALSE(tree.is_whole());
    tree.Push({k, k + 1}, std::to_string(k), Join);
  }
  return tree.TakeWhole();
}
std::vector<Index> Ascending(Index terms) {
  std::vector<Index> order(static_cast<std::size_t>(terms));
  std::iota(order.begin(), order.end(), Index{0});
  return order;
}

TEST(SumTree, IsTheSameForEachNumberOfTerms) {
  const std::pair<Index, const char*> known[] = {{1, "0"},
                                                 {2, "(0+1)"},
                                                 {3, "((0+1)+2)"},
                                                 {5, "(((0+1)+(2+3))+4)"},
                                                 {6, "(((0+1)+(2+3))+(4+5))"},
                                                 {7, "(((0+1)+(2+3))+((4+5)+6))"},
                                                 {9, "((((0+1)+(2+3))+((4+5)+(6+7)))+8)"}};
  for (const auto& [terms, sum] : known) EXPECT_EQ(WordsOf(terms, Ascending(terms)), sum);
}

TEST(SumTree, TermsComeInAnyOrder) {
  for (const Index terms : {3, 4, 5, 6}) {
    std::vector<Index> order = Ascending(terms);
    const std::string expected = WordsOf(terms, order);
    while (std::next_permutation(order.begin(), order.end())) ASSERT_EQ(WordsOf(terms, order), expected);
  }
}

TEST(SumTree, StoresFewValues) {
  TreeSum<int> tree(128);
  std::size_t most = 0;
  for (Index k = 0; k < 128; ++k) {
    tree.Push({k, k + 1}, 1, [](const TreeNode&, int& a, const TreeNode&, int b) { a += b; });
    most = std::max(most, tree.parts().size());
  }
  EXPECT_EQ(most, 7U);
  EXPECT_EQ(tree.TakeWhole(), 128);
}

TEST(SumTree, MisuseIsNamed) {
  EXPECT_THROW(TreeSum<std::string>(0), Error);
  for (const TreeNode node : {TreeNode{5, 6}, {-1, 0}, {1, 3}, {0, 3}, {2, 2}, {4, 6}}) {
    EXPECT_THROW(TreeSum<std::string>(5).Push(node, "", Join), Error) << node.begin << " " << node.end;
  }
  TreeSum<std::string> tree(5);
  tree.Push({3, 4}, "", Join);
  EXPECT_THROW(tree.Push({3, 4}, "", Join), Error);
  EXPECT_THROW(tree.TakeWhole(), Error);
}

}  // namespace
}  // namespace vesta
