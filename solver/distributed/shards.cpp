// SPDX-License-Identifier: Apache-2.0
#include "solver/distributed/shards.h"

#include <algorithm>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta {
namespace {

// Pieces begin at a multiple of this number of blocks, or at the end: that many are factorised together in vector
// registers.
constexpr Index kBlocksAbreast = 16;

// Appends the entries of these blocks.
void AddEntries(const BlockGroup& group, Share blocks, std::vector<EntryRange>* ranges) {
  if (group.block_stride == 1) {
    for (int c = 0; c < group.size; ++c) {
      const Index first = group.Parameter(blocks.begin, c);
      ranges->push_back({first, first + blocks.size()});
    }
    return;
  }
  for (Index block = blocks.begin; block < blocks.end; ++block) {
    for (int c = 0; c < group.size; ++c) {
      const Index entry = group.Parameter(block, c);
      ranges->push_back({entry, entry + 1});
    }
  }
}

}  // namespace

Shards::Shards(Communicator& ranks, Index size, const std::vector<BlockGroup>& groups, int num_pieces)
    : ranks_(ranks), size_(size), whole_groups_(groups), num_pieces_(num_pieces) {
  VESTA_CHECK(num_pieces >= ranks.size(), "{} pieces for {} processes", num_pieces, ranks.size());
  of_ranks_.reserve(static_cast<std::size_t>(ranks.size()));
  Index covered = 0;
  for (int r = 0; r < ranks.size(); ++r) covered += of_ranks_.emplace_back(EntriesOf(PiecesOf(r))).size();
  VESTA_CHECK(covered == size, "block groups cover {} of {} entries", covered, size);
  groups_.reserve(groups.size());
  for (const BlockGroup& group : groups) groups_.push_back(WithinOwn(group));
  const Share mine = PiecesOf(ranks.rank());
  for (auto piece = mine.begin; piece < mine.end; ++piece) {
    // One range per run in the whole, even if runs touch in the shard, so the order of a sum depends on the piece only.
    const Support entries = EntriesOf({piece, piece + 1});
    std::vector<EntryRange>& places = own_pieces_.emplace_back();
    for (const EntryRange& range : entries.ranges()) {
      const Index begin = own().CountBefore(range.begin);
      places.push_back({begin, begin + range.size()});
    }
  }
}

Share Shards::BlocksOf(const BlockGroup& group, Share pieces) const {
  const auto bound = [&](std::int64_t piece) {
    return piece == num_pieces_ ? group.count : group.count * piece / num_pieces_ / kBlocksAbreast * kBlocksAbreast;
  };
  return {bound(pieces.begin), bound(pieces.end)};
}

Support Shards::EntriesOf(Share pieces) const {
  std::vector<EntryRange> ranges;
  for (const BlockGroup& group : whole_groups_) AddEntries(group, BlocksOf(group, pieces), &ranges);
  return Support(std::move(ranges));
}

BlockGroup Shards::WithinOwn(const BlockGroup& group) const {
  const Share blocks = BlocksOf(group, PiecesOf(ranks_.rank()));
  BlockGroup own_group{.size = group.size, .count = blocks.size()};
  if (blocks.size() == 0) return own_group;
  const auto place = [&](Index block, int component) {
    return own().CountBefore(group.Parameter(blocks.begin + block, component));
  };
  own_group.offset = place(0, 0);
  if (group.size > 1) own_group.component_stride = place(0, 1) - own_group.offset;
  if (blocks.size() > 1) own_group.block_stride = place(1, 0) - own_group.offset;
  const Index last = place(blocks.size() - 1, group.size - 1);
  VESTA_CHECK(last == own_group.Parameter(blocks.size() - 1, group.size - 1),
              "groups of blocks that lie within each other cannot be cut");
  return own_group;
}

std::vector<Support> Shards::BlockValuesOfRanks() const {
  std::vector<Support> values;
  values.reserve(of_ranks_.size());
  for (int r = 0; r < ranks_.size(); ++r) {
    std::vector<EntryRange> ranges;
    Index first = 0;
    for (const BlockGroup& group : whole_groups_) {
      const Share blocks = BlocksOf(group, PiecesOf(r));
      for (int element = 0; element < PackedSize(group.size); ++element) {
        const Index begin = first + element * group.count + blocks.begin;
        ranges.push_back({begin, begin + blocks.size()});
      }
      first += group.NumValues();
    }
    values.emplace_back(std::move(ranges));
  }
  return values;
}

template <class S>
void Shards::Take(HostSpan<const S> whole, HostSpan<S> shard) const {
  VESTA_CHECK(whole.size() == size_ && shard.size() == own().size(), "a shard of {} entries of {}", shard.size(),
              whole.size());
  CpuBackend<S> backend;
  Index at = 0;
  for (const EntryRange& range : own().ranges()) {
    backend.Copy(whole.subspan(range.begin, range.size()), shard.subspan(at, range.size()));
    at += range.size();
  }
}

template <class S>
void Shards::Gather(HostSpan<const S> shard, HostSpan<S> whole, HostBuffer<S>& storage) const {
  VESTA_CHECK(whole.size() == size_ && shard.size() == own().size(), "a shard of {} entries of {}", shard.size(),
              whole.size());
  CpuBackend<S> backend;
  if (is_whole()) return backend.Copy(shard, whole);
  storage.ResizeForOverwrite(size_);
  std::vector<std::size_t> counts;
  counts.reserve(of_ranks_.size());
  Index before = 0;
  for (int r = 0; r < ranks_.size(); ++r) {
    const Support& entries = of_ranks_[static_cast<std::size_t>(r)];
    if (r < ranks_.rank()) before += entries.size();
    counts.push_back(static_cast<std::size_t>(entries.size()));
  }
  backend.Copy(shard, storage.view().subspan(before, shard.size()));
  GatherInto(ranks_, std::span<S>(storage.data(), static_cast<std::size_t>(size_)), counts);
  Index at = 0;
  for (const Support& entries : of_ranks_) {
    for (const EntryRange& range : entries.ranges()) {
      backend.Copy(storage.view().subspan(at, range.size()), whole.subspan(range.begin, range.size()));
      at += range.size();
    }
  }
}

template <class S>
template <class Of>
double ShardProducts<S>::SumPieces(const Of& of) const {
  const auto& pieces = shards_.own_pieces();
  std::vector<double> sums(static_cast<std::size_t>(shards_.num_pieces()));
  std::vector<std::size_t> counts;
  counts.reserve(static_cast<std::size_t>(shards_.ranks().size()));
  for (int r = 0; r < shards_.ranks().size(); ++r)
    counts.push_back(static_cast<std::size_t>(shards_.PiecesOf(r).size()));
  double* const mine = sums.data() + shards_.PiecesOf(shards_.ranks().rank()).begin;
  ParallelFor(static_cast<Index>(pieces.size()), 1, [&](Index k) {
    double sum = 0;
    for (const EntryRange& range : pieces[static_cast<std::size_t>(k)]) sum += of(range);
    mine[k] = sum;
  });
  GatherInto(shards_.ranks(), std::span(sums), counts);
  return SumByTree(sums);
}

template <class S>
double ShardProducts<S>::Dot(ConstVectorView x, ConstVectorView y) const {
  return SumPieces([&](const EntryRange& range) {
    return B().Dot(x.subspan(range.begin, range.size()), y.subspan(range.begin, range.size()));
  });
}

template <class S>
void ShardProducts<S>::Dot(ConstVectorView x, ConstVectorView y, typename B::Slot slot) const {
  *slot.value = Dot(x, y);
}

template <class S>
void ShardProducts<S>::WeightedDot(ConstVectorView w, ConstVectorView x, ConstVectorView y,
                                   typename B::Slot slot) const {
  *slot.value = SumPieces([&](const EntryRange& range) {
    const auto of = [&](ConstVectorView v) { return v.subspan(range.begin, range.size()); };
    return B().WeightedDot(of(w), of(x), of(y));
  });
}

template <class S>
bool ShardProducts<S>::AllFinite(ConstVectorView x) const {
  return !OnAnyRank(shards_.ranks(), !B().AllFinite(x));
}

template void Shards::Take(HostSpan<const float>, HostSpan<float>) const;
template void Shards::Take(HostSpan<const double>, HostSpan<double>) const;
template void Shards::Gather(HostSpan<const float>, HostSpan<float>, HostBuffer<float>&) const;
template void Shards::Gather(HostSpan<const double>, HostSpan<double>, HostBuffer<double>&) const;
template class ShardProducts<float>;
template class ShardProducts<double>;

}  // namespace vesta
