// SPDX-License-Identifier: Apache-2.0
#include "kernels/ranks/sum_over_ranks.h"

#include <algorithm>
#include <numeric>

#include "kernels/core/check.h"

namespace vesta {
namespace {

// Gathers the supports of all terms; each rank knows its own.
std::vector<Support> GatherSupports(Communicator& ranks, Index terms, const std::vector<Support>& mine) {
  std::vector<Index> counts;
  counts.reserve(mine.size());
  std::vector<EntryRange> ranges;
  for (const Support& support : mine) {
    counts.push_back(static_cast<Index>(support.ranges().size()));
    ranges.insert(ranges.end(), support.ranges().begin(), support.ranges().end());
  }
  counts = GatherValues(ranks, counts);
  ranges = GatherValues(ranks, ranges);
  VESTA_CHECK(static_cast<Index>(counts.size()) == terms, "got supports of {} terms, want {}", counts.size(), terms);
  std::vector<Support> all;
  auto at = ranges.begin();
  for (const Index count : counts) {
    all.emplace_back(std::vector<EntryRange>(at, at + count));
    at += count;
  }
  return all;
}

}  // namespace

void CheckTerms(Index terms, const Communicator& ranks) {
  if (ranks.size() > terms) {
    Fail(kBadArgument, "{} processes are too many for a problem of {} parts; start at most {}", ranks.size(), terms,
         terms);
  }
}

SumPlan::SumPlan(Communicator& ranks, Index terms, Index size, const std::vector<Support>& mine,
                 std::vector<Support> finished)
    : ranks_(ranks), terms_(terms), size_(size), finished_(std::move(finished)) {
  CheckTerms(terms, ranks);
  if (finished_.empty()) {
    for (int r = 0; r < ranks.size(); ++r) {
      const Share share = ShareOf(size, ranks.size(), r);
      finished_.push_back(Support({{share.begin, share.end}}));
    }
  }
  const std::vector<Support> all = GatherSupports(ranks, terms, mine);
  for (Index term = 0; term < terms; ++term) supports_[{term, term + 1}] = all[static_cast<std::size_t>(term)];
  for (Index width = 2; width < 2 * terms; width *= 2) {
    for (Index begin = 0; begin < terms; begin += width) {
      const Index middle = std::min(begin + width / 2, terms), end = std::min(begin + width, terms);
      if (middle < end) supports_[{begin, end}] = Union(supports_.at({begin, middle}), supports_.at({middle, end}));
    }
  }
  for (const auto& [node, support] : supports_) mine_[node] = Intersection(support, OwnedEntries(ranks.rank()));
  nodes_.reserve(static_cast<std::size_t>(ranks.size()));
  for (int r = 0; r < ranks.size(); ++r) {
    const TreeNode run = TermsOf(terms, ranks, r);
    nodes_.push_back(NodesOf(run.begin, run.end, terms));
  }
  for (const TreeNode& node : nodes(ranks.rank())) {
    for (int r = 0; r < ranks.size(); ++r) sent_.push_back(PositionsIn(OwnedEntries(r), Of(node)));
  }
  const Support& root = Of({0, terms});
  whole_counts_.reserve(static_cast<std::size_t>(ranks.size()));
  for (int r = 0; r < ranks.size(); ++r) {
    whole_counts_.push_back(static_cast<std::size_t>(Intersection(root, OwnedEntries(r)).size()));
  }
  own_positions_ = Support(PositionsIn(OfMine({0, terms}), OwnedEntries(ranks.rank())));
}

Index SumPlan::ReceivedValuesOfShare(int rank) const {
  Index values = 0;
  for (int r = 0; r < ranks_.size(); ++r) {
    if (r == rank) continue;
    for (const TreeNode& node : nodes(r)) values += Intersection(Of(node), OwnedEntries(rank)).size();
  }
  return values;
}

Index SumPlan::ReceivedValues(int rank) const {
  return ReceivedValuesOfShare(rank) + Of({0, terms_}).size() -
         static_cast<Index>(whole_counts_[static_cast<std::size_t>(rank)]);
}

template <class S>
HostBuffer<S> SumOverRanks<S>::TakeBuffer(Index size) {
  HostBuffer<S> buffer;
  if (!free_.empty()) {
    buffer = std::move(free_.back());
    free_.pop_back();
  }
  buffer.ResizeForOverwrite(size);
  return buffer;
}

template <class S>
template <class SupportOf>
void SumOverRanks<S>::Push(TreeSum<HostBuffer<S>>& sum, const TreeNode& node, HostBuffer<S>&& value,
                           const SupportOf& support_of) {
  sum.Push(node, std::move(value),
           [&](const TreeNode& left, HostBuffer<S>& a, const TreeNode& right, HostBuffer<S>& b) {
             AddCompact<S>(support_of(left), a, support_of(right), std::as_const(b).view(),
                           support_of({left.begin, right.end}), spare_);
             free_.push_back(std::move(b));
           });
}

template <class S>
void SumOverRanks<S>::PushTerm(TreeSum<HostBuffer<S>>& sum, Index term, HostBuffer<S>&& value) {
  Push(sum, {term, term + 1}, std::move(value), [&](const TreeNode& n) -> const Support& { return plan_.Of(n); });
}

template <class S>
void SumOverRanks<S>::FinishWhole(TreeSum<HostBuffer<S>>& sum, HostSpan<S> out) {
  VESTA_CHECK(out.size() == plan_.size(), "the sum has {} entries, the output {}", plan_.size(), out.size());
  const Support& root = plan_.Of({0, plan_.terms()});
  const int size = plan_.ranks().size();
  HostBuffer<S> finished = Collect(sum);
  if (size == 1) {
    Expand<S>(root, std::as_const(finished).view(), out);
    free_.push_back(std::move(finished));
    return;
  }
  // The finished shares, in rank order, form the compact vector of the sum.
  const std::vector<std::size_t>& counts = plan_.whole_counts();
  const std::size_t before = std::accumulate(counts.begin(), counts.begin() + plan_.ranks().rank(), std::size_t{0});
  const bool is_all = root.IsAll(out.size());
  HostBuffer<S> compact = is_all ? HostBuffer<S>() : TakeBuffer(root.size());
  const HostSpan<S> all = is_all ? out : compact.view();
  std::copy(finished.begin(), finished.end(), all.data() + before);
  GatherInto(plan_.ranks(), std::span<S>(all.data(), static_cast<std::size_t>(all.size())), counts);
  if (!is_all) Expand<S>(root, std::as_const(compact).view(), out);
  free_.push_back(std::move(finished));
  if (!is_all) free_.push_back(std::move(compact));
}

template <class S>
void SumOverRanks<S>::FinishShare(TreeSum<HostBuffer<S>>& sum, HostSpan<S> out) {
  const Support& share = plan_.OwnedEntries(plan_.ranks().rank());
  VESTA_CHECK(out.size() == share.size(), "the share has {} entries, the output {}", share.size(), out.size());
  HostBuffer<S> finished = Collect(sum);
  Expand<S>(plan_.own_positions(), std::as_const(finished).view(), out);
  free_.push_back(std::move(finished));
}

// Returns the sum of all terms at the entries that this rank finishes, as a compact vector.
template <class S>
HostBuffer<S> SumOverRanks<S>::Collect(TreeSum<HostBuffer<S>>& sum) {
  Communicator& ranks = plan_.ranks();
  const int size = ranks.size();
  if (size == 1) return sum.TakeWhole();
  std::vector<std::size_t> send_sizes(static_cast<std::size_t>(size)), receive_sizes(send_sizes);
  Index sent = 0, received = 0;
  for (int r = 0; r < size; ++r) {
    Index to = 0, from = 0;
    for (std::size_t k = 0; k < sum.parts().size(); ++k) {
      for (const EntryRange& range : plan_.SentTo(k, r)) to += range.size();
    }
    for (const TreeNode& node : plan_.nodes(r)) from += plan_.OfMine(node).size();
    send_sizes[static_cast<std::size_t>(r)] = static_cast<std::size_t>(to) * sizeof(S);
    receive_sizes[static_cast<std::size_t>(r)] = static_cast<std::size_t>(from) * sizeof(S);
    sent += to, received += from;
  }
  HostBuffer<S> outgoing = TakeBuffer(sent), incoming = TakeBuffer(received);
  S* to = outgoing.data();
  for (int r = 0; r < size; ++r) {
    for (std::size_t k = 0; k < sum.parts().size(); ++k) {
      const S* const value = sum.parts()[k].second.data();
      for (const EntryRange& range : plan_.SentTo(k, r)) to = std::copy_n(value + range.begin, range.size(), to);
    }
  }
  for (auto& [node, value] : sum.TakeParts()) free_.push_back(std::move(value));
  const auto bytes = [](HostBuffer<S>& buffer) {
    return std::as_writable_bytes(std::span<S>(buffer.data(), static_cast<std::size_t>(buffer.size())));
  };
  ranks.AllToAll(bytes(outgoing), send_sizes, bytes(incoming), receive_sizes);
  TreeSum<HostBuffer<S>> finished(plan_.terms());
  const S* from = incoming.data();
  for (int r = 0; r < size; ++r) {
    for (const TreeNode& node : plan_.nodes(r)) {
      HostBuffer<S> value = TakeBuffer(plan_.OfMine(node).size());
      std::copy_n(from, value.size(), value.data());
      from += value.size();
      Push(finished, node, std::move(value), [&](const TreeNode& n) -> const Support& { return plan_.OfMine(n); });
    }
  }
  free_.push_back(std::move(outgoing));
  free_.push_back(std::move(incoming));
  return finished.TakeWhole();
}

template class SumOverRanks<float>;
template class SumOverRanks<double>;

}  // namespace vesta
