// SPDX-License-Identifier: Apache-2.0
#include "kernels/ranks/sum_tree.h"

#include <algorithm>

namespace vesta {
namespace {

// The terms of the node that begins here. size: number of terms of a full node of the level.
TreeNode NodeAt(Index begin, Index size, Index count) { return {begin, std::min(begin + size, count)}; }

}  // namespace

bool IsNode(const TreeNode& node, Index count) {
  if (node.begin < 0 || node.begin >= node.end || node.end > count) return false;
  for (Index size = 1; node.begin % size == 0; size *= 2) {
    if (NodeAt(node.begin, size, count) == node) return true;
    if (size >= count) break;
  }
  return false;
}

bool AreHalves(const TreeNode& left, const TreeNode& right, Index count) {
  const Index size = left.end - left.begin;
  const bool is_power_of_two = size > 0 && (size & (size - 1)) == 0;
  return is_power_of_two && left.begin % (2 * size) == 0 && right == NodeAt(left.end, size, count);
}

std::vector<TreeNode> NodesOf(Index begin, Index end, Index count) {
  TreeSum<char> sum(count);
  for (Index term = begin; term < end; ++term) sum.Push({term, term + 1}, 0, [](auto&&...) {});
  std::vector<TreeNode> nodes;
  nodes.reserve(sum.parts().size());
  for (const auto& [node, nothing] : sum.parts()) nodes.push_back(node);
  return nodes;
}

double SumByTree(const std::vector<double>& terms) {
  if (terms.empty()) return 0;
  TreeSum<double> sum(static_cast<Index>(terms.size()));
  Index at = 0;
  for (const double term : terms) {
    sum.Push({at, at + 1}, term, [](const TreeNode&, double& a, const TreeNode&, double b) { a += b; });
    ++at;
  }
  return sum.TakeWhole();
}

}  // namespace vesta
