// SPDX-License-Identifier: Apache-2.0
// Sums in an order that does not depend on who forms them: a binary tree over the terms 0 .. count - 1.
//
// A node of level k covers 2^k terms, the i-th those from i 2^k on (the last of a level fewer), and is the sum of its
// two halves, the left one first. Any run of terms is made up of few nodes, at most two a level; who holds those of all
// runs adds them up to the same bits, wherever the runs begin.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/span.h"

namespace vesta {

// Terms begin .. end - 1.
struct TreeNode {
  Index begin = 0, end = 0;
  friend bool operator==(const TreeNode&, const TreeNode&) = default;
};

// Whether a tree over `count` terms has this node.
bool IsNode(const TreeNode& node, Index count);
// Whether the two are the halves of a node of a tree over `count` terms.
bool AreHalves(const TreeNode& left, const TreeNode& right, Index count);
// The nodes that the terms begin .. end - 1 add up to, from the left; at most two a level.
std::vector<TreeNode> NodesOf(Index begin, Index end, Index count);

// Adds up terms, and nodes that were added up elsewhere, as far as the tree allows, in whatever order they come.
template <class T>
class TreeSum {
 public:
  using Part = std::pair<TreeNode, T>;

  // count: of the terms, at least one.
  explicit TreeSum(Index count) : count_(count) { VESTA_CHECK(count > 0, "a sum of {} terms", count); }

  // add(node, a, other, b): a += b, of the left and the right half of a node. Called as often as halves meet. Where
  // terms come from the first to the last no more of them are held than the tree has levels.
  template <class Add>
  void Push(TreeNode node, T value, const Add& add) {
    CheckIsNew(node);
    for (auto half = HalfBeside(node); half != parts_.end(); half = HalfBeside(node)) {
      auto [other, other_value] = std::move(*half);
      parts_.erase(half);
      if (other.begin < node.begin) std::swap(node, other), std::swap(value, other_value);
      add(node, value, other, other_value);
      node.end = other.end;
    }
    const auto after = std::ranges::find_if(parts_, [&](const Part& part) { return part.first.begin > node.begin; });
    parts_.emplace(after, node, std::move(value));
  }
  // What is there so far, from the left.
  const std::vector<Part>& parts() const { return parts_; }
  std::vector<Part> TakeParts() { return std::exchange(parts_, {}); }
  bool is_whole() const { return parts_.size() == 1 && parts_[0].first == (TreeNode{0, count_}); }
  // Needs is_whole().
  T TakeWhole() {
    VESTA_CHECK(is_whole(), "a sum of {} terms that lacks some", count_);
    return std::move(TakeParts()[0].second);
  }

 private:
  auto HalfBeside(const TreeNode& node) {
    return std::ranges::find_if(parts_, [&](const Part& part) {
      return AreHalves(part.first, node, count_) || AreHalves(node, part.first, count_);
    });
  }
  void CheckIsNew(const TreeNode& node) const {
    VESTA_CHECK(IsNode(node, count_), "no part {} to {} in a sum of {} terms", node.begin, node.end, count_);
    const auto overlaps = [&](const Part& part) { return part.first.begin < node.end && node.begin < part.first.end; };
    VESTA_CHECK(std::ranges::none_of(parts_, overlaps), "terms {} to {} were added twice", node.begin, node.end - 1);
  }

  Index count_;
  std::vector<Part> parts_;  // from the left
};

// Of numbers.
double SumByTree(const std::vector<double>& terms);

}  // namespace vesta
