// Sums in an order that does not depend on who forms them: a binary tree over the terms 0 .. count - 1.
//
// A node of level k covers 2^k terms, the i-th those from i 2^k on (the last of a level fewer), and is the sum of its
// two halves, the left one first. Any run of terms is made up of few nodes, at most two a level; who holds those of all
// runs adds them up to the same bits, wherever the runs begin.
#pragma once

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

// Whether the two are the halves of a node of a tree over `count` terms.
bool AreHalves(const TreeNode& left, const TreeNode& right, Index count);
// The nodes that the terms begin .. end - 1 add up to, from the left; at most two a level.
std::vector<TreeNode> NodesOf(Index begin, Index end, Index count);

// Adds up terms or nodes that come from the left to the right, as far as the tree allows.
template <class T>
class TreeSum {
 public:
  explicit TreeSum(Index count) : count_(count) {}

  // add(node, a, node, b): a += b, of the two halves of a node. Called as often as halves meet.
  template <class Add>
  void Push(TreeNode node, T value, const Add& add) {
    VESTA_CHECK(nodes_.empty() || nodes_.back().first.end == node.begin, "term {} after those before {}", node.begin,
                nodes_.back().first.end);
    nodes_.emplace_back(node, std::move(value));
    while (nodes_.size() > 1 && AreHalves(nodes_[nodes_.size() - 2].first, nodes_.back().first, count_)) {
      auto& [left, sum] = nodes_[nodes_.size() - 2];
      auto& [right, other] = nodes_.back();
      add(left, sum, right, other);
      left.end = right.end;
      nodes_.pop_back();
    }
  }
  // What is there so far, from the left.
  std::vector<std::pair<TreeNode, T>>& nodes() { return nodes_; }
  // The one node that is left, once all terms are in.
  T& whole() {
    VESTA_CHECK(nodes_.size() == 1 && nodes_[0].first == (TreeNode{0, count_}), "a sum of {} terms that lacks some",
                count_);
    return nodes_[0].second;
  }

 private:
  Index count_;
  std::vector<std::pair<TreeNode, T>> nodes_;
};

// Of numbers.
double SumByTree(const std::vector<double>& terms);

}  // namespace vesta
