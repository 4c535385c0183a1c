// SPDX-License-Identifier: Apache-2.0
// Sums of vectors (terms) computed by different ranks, added in the order of the tree of sum_tree.h. The result is
// bit-identical for any number of ranks.
//
// The support of a term is the list of its entries that may differ from zero. The compact vector of the term consists
// of the values of these entries (support.h). A rank finishes an entry if it computes the entry's total over all terms.
// The entries that a rank finishes are its share.
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

// The range of terms that a rank computes.
inline TreeNode TermsOf(Index terms, const Communicator& ranks, int rank) {
  const Share share = ShareOf(terms, ranks.size(), rank);
  return {share.begin, share.end};
}
// Throws Error if there are more ranks than terms.
void CheckTerms(Index terms, const Communicator& ranks);

// Communication plan of a sum: the entries that each rank sends to each other rank. Each rank first adds its own terms
// as far as the tree allows. At most two partial sums (nodes) per level remain. The rank then receives the values of
// its share and adds them. If all ranks need the whole sum, they exchange the finished shares. This transfers as many
// bytes as an all-reduce.
class SumPlan {
 public:
  // Plans sums of `terms` vectors of `size` entries. mine: the supports of this rank's terms (TermsOf). finished: the
  // share of each rank; every entry belongs to exactly one share. If `finished` is empty, the shares are equal ranges
  // of [0, size). Collective.
  SumPlan(Communicator& ranks, Index terms, Index size, const std::vector<Support>& mine,
          std::vector<Support> finished);

  Index terms() const { return terms_; }
  Index size() const { return size_; }
  Communicator& ranks() const { return ranks_; }
  // Support of a node of the tree.
  const Support& Of(const TreeNode& node) const { return supports_.at({node.begin, node.end}); }
  // Intersection of the support of a node with this rank's share.
  const Support& OfMine(const TreeNode& node) const { return mine_.at({node.begin, node.end}); }
  // The nodes of a rank after the rank has added its own terms.
  const std::vector<TreeNode>& nodes(int rank) const { return nodes_[static_cast<std::size_t>(rank)]; }
  // The share of a rank.
  const Support& OwnedEntries(int rank) const { return finished_[static_cast<std::size_t>(rank)]; }
  // Positions, in the compact vector of this rank's k-th node, of the entries in the share of `rank`.
  const std::vector<EntryRange>& SentTo(std::size_t node, int rank) const {
    return sent_[node * static_cast<std::size_t>(ranks_.size()) + static_cast<std::size_t>(rank)];
  }
  // For each rank: number of entries of its share at which the sum may be nonzero.
  const std::vector<std::size_t>& whole_counts() const { return whole_counts_; }
  // For this rank: positions of these entries within its share.
  const Support& own_positions() const { return own_positions_; }
  // Number of values that a rank receives for its share of the sum, and for the whole sum.
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
  Support own_positions_;
};

// Computes sums by a SumPlan. S: float or double, in host memory.
template <class S>
class SumOverRanks {
 public:
  SumOverRanks(Communicator& ranks, Index terms, Index size, const std::vector<Support>& mine,
               std::vector<Support> finished = {})
      : plan_(ranks, terms, size, mine, std::move(finished)) {}

  const SumPlan& plan() const { return plan_; }
  // Frees the buffers that are kept for the next sum.
  void Release() { free_.clear(), spare_ = {}; }
  // out = the sum of all terms. make(term, to) writes the complete compact vector of a term. Calls `make` for each term
  // of this rank. The shares must be in rank order. Collective.
  template <class Make>
  void Sum(const Make& make, HostSpan<S> out) {
    TreeSum<HostBuffer<S>> sum = SumOwnTerms(make);
    FinishWhole(sum, out);
  }
  // out = this rank's share of the sum, as a compact vector. Collective.
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
  // Exchanges partial sums. Returns the finished values of this rank's share.
  HostBuffer<S> Collect(TreeSum<HostBuffer<S>>& sum);

  SumPlan plan_;
  std::vector<HostBuffer<S>> free_;
  HostBuffer<S> spare_;
};

}  // namespace vesta
