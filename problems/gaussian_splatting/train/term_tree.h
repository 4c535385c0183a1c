// Sums of terms in the order of a fixed binary tree, so that the bits of a sum are the same whoever computed which part
// of it, and whatever came first.
//
// Terms 0 and 1 are added, 2 and 3, and so on; then these sums by twos; and so on up. Where one is alone at the end of
// a level, it goes up as it is. A share of the terms that begins at a multiple of a power of two, and is as long as
// that or ends with the last term, is one node of the tree: whoever has that share hands on one term.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/span.h"

namespace vesta::gs {

// The sum of the terms from place << level on, before (place + 1) << level, as far as there are terms.
struct TreeNode {
  int level = 0;
  Index place = 0;

  friend bool operator==(const TreeNode&, const TreeNode&) = default;
};

template <class Term>
class TermTree {
 public:
  struct Part {
    TreeNode node;
    Term term;
  };

  // terms: how many there are in all, one or more.
  explicit TermTree(Index terms) : terms_(terms) {
    VESTA_CHECK(terms > 0, "a sum of {} terms", terms);
    while ((Index{1} << top_) < terms) ++top_;
  }

  // In any order, each once: a term by itself, or a node that was added up elsewhere (TakeParts). join(left, right)
  // leaves the sum of both in left. Adding up term by term from the first on, at most top + 1 terms are held, top being
  // the binary logarithm of their number, rounded up.
  template <class Join>
  void Add(TreeNode node, Term term, const Join& join) {
    const bool is_there = node.level >= 0 && node.level <= top_ && node.place >= 0 && Begin(node) < terms_;
    VESTA_CHECK(is_there, "no part ({}, {}) in a sum of {} terms", node.level, node.place, terms_);
    for (; node.level < top_; ++node.level, node.place /= 2) {
      const TreeNode beside{node.level, node.place ^ 1};
      if (Begin(beside) >= terms_) continue;
      const auto waiting = std::ranges::find(parts_, beside, &Part::node);
      if (waiting == parts_.end()) break;
      Term other = std::move(waiting->term);
      parts_.erase(waiting);
      if (beside.place < node.place) std::swap(term, other);
      join(term, std::move(other));
    }
    VESTA_CHECK(std::ranges::find(parts_, node, &Part::node) == parts_.end(), "part ({}, {}) was added twice",
                node.level, node.place);
    parts_.push_back({node, std::move(term)});
  }

  // Whether all terms are there.
  bool is_whole() const { return parts_.size() == 1 && parts_.front().node.level == top_; }
  // Needs is_whole().
  Term TakeSum() {
    VESTA_CHECK(is_whole(), "terms are missing in a sum of {}", terms_);
    return std::move(TakeParts().front().term);
  }
  // What there is so far, each part joined as far as that goes: of a share of the terms, what others are to add.
  std::vector<Part> TakeParts() { return std::exchange(parts_, {}); }

 private:
  Index Begin(const TreeNode& node) const { return node.place << node.level; }

  Index terms_;
  int top_ = 0;
  std::vector<Part> parts_;
};

}  // namespace vesta::gs
