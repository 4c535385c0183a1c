// SPDX-License-Identifier: Apache-2.0
// Summation in an order that does not depend on the division of the terms among ranks: along a binary tree over the
// terms 0 .. count - 1.
//
// The i-th node of level k covers the 2^k terms from i 2^k on. The last node of a level may cover fewer terms. The
// value of a node is the value of its left half plus the value of its right half. Any contiguous range of terms
// consists of at most two nodes per level. If each rank adds one range, the borders of the ranges therefore do not
// change any bit of the total.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/span.h"

namespace vesta {

// A node of the tree: the terms begin .. end - 1.
struct TreeNode {
  Index begin = 0, end = 0;
  friend bool operator==(const TreeNode&, const TreeNode&) = default;
};

// Whether `node` is a node of a tree over `count` terms.
bool IsNode(const TreeNode& node, Index count);
// Whether left and right are the two halves of a node of a tree over `count` terms.
bool AreHalves(const TreeNode& left, const TreeNode& right, Index count);
// The fewest nodes that together cover the terms begin .. end - 1, from left to right.
std::vector<TreeNode> NodesOf(Index begin, Index end, Index count);

// Adds terms, and nodes that other ranks have summed, as far as the tree allows. They may be pushed in any order.
template <class T>
class TreeSum {
 public:
  using Part = std::pair<TreeNode, T>;

  // count: number of terms, at least one.
  explicit TreeSum(Index count) : count_(count) { VESTA_CHECK(count > 0, "a sum of {} terms", count); }

  // Adds a term or node. Throws Error if it is not a node of the tree, or was added before. add(left, a, right, b) must
  // compute a += b for the two halves of a node. It is called as soon as both halves are known. If terms are added in
  // ascending order, at most one value per level is stored.
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
  // The nodes summed so far, from the left.
  const std::vector<Part>& parts() const { return parts_; }
  std::vector<Part> TakeParts() { return std::exchange(parts_, {}); }
  bool is_whole() const { return parts_.size() == 1 && parts_[0].first == (TreeNode{0, count_}); }
  // is_whole() must be true.
  T TakeWhole() {
    VESTA_CHECK(is_whole(), "some of the {} terms of the sum are missing", count_);
    return std::move(TakeParts()[0].second);
  }

 private:
  auto HalfBeside(const TreeNode& node) {
    return std::ranges::find_if(parts_, [&](const Part& part) {
      return AreHalves(part.first, node, count_) || AreHalves(node, part.first, count_);
    });
  }
  void CheckIsNew(const TreeNode& node) const {
    VESTA_CHECK(IsNode(node, count_), "terms {} to {} are not a node of a sum of {} terms", node.begin, node.end,
                count_);
    const auto overlaps = [&](const Part& part) { return part.first.begin < node.end && node.begin < part.first.end; };
    VESTA_CHECK(std::ranges::none_of(parts_, overlaps), "terms {} to {} were added twice", node.begin, node.end - 1);
  }

  Index count_;
  std::vector<Part> parts_;  // from the left
};

// Sums numbers in the order of the tree.
double SumByTree(const std::vector<double>& terms);

}  // namespace vesta
