// SPDX-License-Identifier: Apache-2.0
// The sum of vectors that are spread over ranks, in the order of the tree of sum_tree.h: the same bits for any number
// of ranks.
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/ranks/communicator.h"
#include "kernels/ranks/sum_tree.h"
#include "kernels/ranks/support.h"

namespace vesta {

// The terms that a rank forms.
inline TreeNode TermsOf(Index terms, const Communicator& ranks, int rank) {
  const Share share = ShareOf(terms, ranks.size(), rank);
  return {share.begin, share.end};
}
// Throws Error where there are more ranks than terms.
void CheckTerms(Index terms, const Communicator& ranks);

// What of a sum's exchange is known beforehand: who sends whom which entries. Each rank first adds up what the tree
// lets it (at most two vectors a level are left), then collects its share of all entries from the others and finishes
// those. Where all want the whole sum they hand round what they finished: the bytes of an all-reduce.
class SumPlan {
 public:
  // Sums of `terms` vectors of `size` entries; mine: where those of this rank (TermsOf) may differ from zero.
  // finished: the entries that each rank finishes, each entry once; empty: of each a share of [0, size).
  SumPlan(Communicator& ranks, Index terms, Index size, const std::vector<Support>& mine,
          std::vector<Support> finished);

  Index terms() const { return terms_; }
  Index size() const { return size_; }
  Communicator& ranks() const { return ranks_; }
  // Of a node that arises on the way: all of it, and within the entries that this rank finishes.
  const Support& Of(const TreeNode& node) const { return supports_.at({node.begin, node.end}); }
  const Support& OfMine(const TreeNode& node) const { return mine_.at({node.begin, node.end}); }
  // What the rank has once it has added up its own terms.
  const std::vector<TreeNode>& nodes(int rank) const { return nodes_[static_cast<std::size_t>(rank)]; }
  // The entries that a rank finishes.
  const Support& FinishedBy(int rank) const { return finished_[static_cast<std::size_t>(rank)]; }
  // Of this rank's k-th node, where in its compact vector the entries lie that a rank finishes.
  const std::vector<EntryRange>& SentTo(std::size_t node, int rank) const {
    return sent_[node * static_cast<std::size_t>(ranks_.size()) + static_cast<std::size_t>(rank)];
  }
  // Of the sum, how many entries may differ from zero of those that each rank finishes; and where those of this rank
  // lie in its share.
  const std::vector<std::size_t>& whole_counts() const { return whole_counts_; }
  const Support& places_in_share() const { return places_in_share_; }
  // The values that a rank receives until it has its share, and until it has the whole sum.
  Index ReceivedValuesOfShare(int rank) const;
  Index ReceivedValues(int rank) const;

 private:
  Communicator& ranks_;
  Index terms_, size_;
  std::map<std::pair<Index, Index>, Support> supports_, mine_;
  std::vector<std::vector<TreeNode>> nodes_;
  std::vector<Support> finished_;
  std::vector<std::vector<EntryRange>> sent_;
  std::vector<std::size_t> whole_counts_;
  Support places_in_share_;
};

// S: float or double, in host memory.
template <class S>
class SumOverRanks {
 public:
  SumOverRanks(Communicator& ranks, Index terms, Index size, const std::vector<Support>& mine,
               std::vector<Support> finished = {})
      : plan_(ranks, terms, size, mine, std::move(finished)) {}

  const SumPlan& plan() const { return plan_; }
  // Frees what is kept from one sum for the next.
  void Release() { free_.clear(), spare_ = {}; }
  // out = the sum of all terms. make(term, to) writes all of the term's compact vector, for each term of this rank.
  // Needs ranks that finish the entries in their order.
  template <class Make>
  void Sum(const Make& make, HostSpan<S> out) {
    TreeSum<HostBuffer<S>> sum = SumOwnTerms(make);
    FinishWhole(sum, out);
  }
  // out = its entries that this rank finishes, a compact vector.
  template <class Make>
  void SumShare(const Make& make, HostSpan<S> out) {
    TreeSum<HostBuffer<S>> sum = SumOwnTerms(make);
    FinishShare(sum, out);
  }

 private:
  template <class Make>
  TreeSum<HostBuffer<S>> SumOwnTerms(const Make& make) {
    TreeSum<HostBuffer<S>> sum(plan_.terms());
    const TreeNode mine = TermsOf(plan_.terms(), plan_.ranks(), plan_.ranks().rank());
    for (Index term = mine.begin; term < mine.end; ++term) {
      HostBuffer<S> value = TakeBuffer(plan_.Of({term, term + 1}).size());
      make(term, value.view());
      PushTerm(sum, term, std::move(value));
    }
    return sum;
  }
  HostBuffer<S> TakeBuffer(Index size);
  void PushTerm(TreeSum<HostBuffer<S>>& sum, Index term, HostBuffer<S>&& value);
  template <class SupportOf>
  void Push(TreeSum<HostBuffer<S>>& sum, const TreeNode& node, HostBuffer<S>&& value, const SupportOf& support_of);
  void FinishWhole(TreeSum<HostBuffer<S>>& sum, HostSpan<S> out);
  void FinishShare(TreeSum<HostBuffer<S>>& sum, HostSpan<S> out);
  // Through the others, unless there are none.
  HostBuffer<S> Collect(TreeSum<HostBuffer<S>>& sum);

  SumPlan plan_;
  std::vector<HostBuffer<S>> free_;
  HostBuffer<S> spare_;
};

}  // namespace vesta
