#include "problems/gaussian_splatting/train/term_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

// A term that tells how it came about.
using Words = TermTree<std::string>;
void Join(std::string& left, const std::string& right) { left = "(" + left + "+" + right + ")"; }

std::string SumOf(Index terms, const std::vector<Index>& order) {
  Words tree(terms);
  for (const Index k : order) {
    EXPECT_FALSE(tree.is_whole());
    tree.Add({0, k}, std::to_string(k), Join);
  }
  EXPECT_TRUE(tree.is_whole());
  return tree.TakeSum();
}
std::vector<Index> Ascending(Index terms) {
  std::vector<Index> order(static_cast<std::size_t>(terms));
  std::iota(order.begin(), order.end(), Index{0});
  return order;
}

TEST(TermTree, IsTheSameForEachNumberOfTerms) {
  const std::pair<Index, const char*> known[] = {{1, "0"},
                                                 {2, "(0+1)"},
                                                 {3, "((0+1)+2)"},
                                                 {4, "((0+1)+(2+3))"},
                                                 {5, "(((0+1)+(2+3))+4)"},
                                                 {6, "(((0+1)+(2+3))+(4+5))"},
                                                 {7, "(((0+1)+(2+3))+((4+5)+6))"},
                                                 {8, "(((0+1)+(2+3))+((4+5)+(6+7)))"},
                                                 {9, "((((0+1)+(2+3))+((4+5)+(6+7)))+8)"}};
  for (const auto& [terms, sum] : known) EXPECT_EQ(SumOf(terms, Ascending(terms)), sum);
}

TEST(TermTree, ComesInAnyOrder) {
  for (const Index terms : {3, 4, 5, 6}) {
    std::vector<Index> order = Ascending(terms);
    const std::string expected = SumOf(terms, order);
    while (std::next_permutation(order.begin(), order.end())) ASSERT_EQ(SumOf(terms, order), expected);
  }
}

// Shares of the terms, added up by one each; those that are whole nodes hand on one term.
TEST(TermTree, ComesInShares) {
  struct Share {
    Index begin, end;
    std::size_t parts;
  };
  const std::pair<Index, std::vector<Share>> cases[] = {
      {4, {{0, 2, 1}, {2, 4, 1}}}, {8, {{4, 8, 1}, {0, 4, 1}}},
      {7, {{0, 4, 1}, {4, 7, 1}}}, {6, {{4, 6, 1}, {0, 2, 1}, {2, 4, 1}}},
      {3, {{2, 3, 1}, {0, 2, 1}}}, {5, {{1, 3, 2}, {0, 1, 1}, {3, 5, 2}}}};
  for (const auto& [terms, shares] : cases) {
    Words all(terms);
    for (const Share& share : shares) {
      Words some(terms);
      for (Index k = share.begin; k < share.end; ++k) some.Add({0, k}, std::to_string(k), Join);
      std::vector<Words::Part> parts = some.TakeParts();
      EXPECT_EQ(parts.size(), share.parts) << terms << ": " << share.begin;
      for (Words::Part& part : parts) all.Add(part.node, std::move(part.term), Join);
    }
    EXPECT_EQ(all.TakeSum(), SumOf(terms, Ascending(terms)));
  }
}

// Term by term, as many are held at a time as the tree is high.
TEST(TermTree, HoldsFewTerms) {
  struct Counted {
    explicit Counted(int* alive) : count(alive, [](int* n) { --*n; }) { ++*alive; }
    std::unique_ptr<int, void (*)(int*)> count;
  };
  int alive = 0, most = 0;
  TermTree<Counted> tree(128);
  for (Index k = 0; k < 128; ++k) {
    tree.Add({0, k}, Counted(&alive), [&](Counted&, const Counted&) { most = std::max(most, alive); });
  }
  EXPECT_EQ(most, 8);
  EXPECT_EQ(alive, 1);
}

TEST(TermTree, MisuseIsNamed) {
  EXPECT_NE(ErrorOf([] { Words(0); }), "");
  for (const TreeNode node : {TreeNode{0, 5}, {0, -1}, {1, 3}, {4, 0}, {-1, 0}}) {
    EXPECT_NE(ErrorOf([&] { Words(5).Add(node, "", Join); }), "") << node.level << " " << node.place;
  }
  EXPECT_NE(ErrorOf([] {
              Words tree(5);
              for (int k = 0; k < 2; ++k) tree.Add({0, 3}, "", Join);
            }),
            "");
  EXPECT_NE(ErrorOf([] {
              Words tree(2);
              tree.Add({0, 0}, "", Join);
              tree.TakeSum();
            }),
            "");
}

}  // namespace
}  // namespace vesta::gs
