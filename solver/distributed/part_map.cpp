// SPDX-License-Identifier: Apache-2.0
#include "solver/distributed/part_map.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "kernels/core/check.h"

namespace vesta {

namespace {

// Merges consecutive segments that are contiguous in the part and in the whole. Sorted input.
void JoinNeighbours(std::vector<PartSegment>& segments) {
  std::vector<PartSegment> joined;
  for (const PartSegment& s : segments) {
    if (s.size == 0) continue;
    PartSegment* const last = joined.empty() ? nullptr : &joined.back();
    if (last && last->whole + last->size == s.whole && last->local + last->size == s.local) {
      last->size += s.size;
    } else {
      joined.push_back(s);
    }
  }
  segments = std::move(joined);
}

}  // namespace

PartMap::PartMap(const std::vector<PartSegment>& segments, Index local_size, Index whole_size, const char* what)
    : segments_(segments), local_size_(local_size) {
  if (segments_.empty() && local_size > 0) {
    if (local_size != whole_size) {
      Fail(kBadArgument, "a part has {} {} of {} but no segments; give its segments", local_size, what, whole_size);
    }
    segments_.push_back({0, 0, whole_size});
  }
  std::sort(segments_.begin(), segments_.end(),
            [](const PartSegment& a, const PartSegment& b) { return a.whole < b.whole; });
  std::vector<EntryRange> ranges, locals;
  ranges.reserve(segments_.size());
  locals.reserve(segments_.size());
  Index entries = 0;
  JoinNeighbours(segments_);
  for (const PartSegment& s : segments_) {
    const bool is_inside =
        s.size > 0 && s.whole >= 0 && s.local >= 0 && s.whole + s.size <= whole_size && s.local + s.size <= local_size;
    if (!is_inside)
      Fail(kBadArgument, "a segment of a part has {} {} to {}; the whole has {}", what, s.whole, s.whole + s.size - 1,
           whole_size);
    is_compact_ = is_compact_ && s.local == entries;
    ranges.push_back({s.whole, s.whole + s.size});
    locals.push_back({s.local, s.local + s.size});
    entries += s.size;
  }
  support_ = Support(std::move(ranges));
  const bool covers =
      entries == local_size && support_.size() == local_size && Support(std::move(locals)).size() == local_size;
  if (!covers)
    Fail(kBadArgument, "a part's segments cover {} {}, but the part has {}; give each once", entries, what, local_size);
  is_identity_ = is_compact_ && local_size == whole_size;
}

template <class S>
void PartMap::Take(HostSpan<const S> whole, HostSpan<S> local) const {
  CpuBackend<S> backend;
  for (const PartSegment& s : segments_) backend.Copy(whole.subspan(s.whole, s.size), local.subspan(s.local, s.size));
}

template <class S>
HostSpan<const S> PartMap::Local(HostSpan<const S> whole, HostBuffer<S>& storage) const {
  if (is_identity_) return whole;
  storage.ResizeForOverwrite(local_size_);
  Take<S>(whole, storage.view());
  return std::as_const(storage).view();
}

template <class S>
void PartMap::MakeCompact(HostSpan<const S> local, HostSpan<S> compact) const {
  CpuBackend<S> backend;
  Index at = 0;
  for (const PartSegment& s : segments_) {
    backend.Copy(local.subspan(s.local, s.size), compact.subspan(at, s.size));
    at += s.size;
  }
}

Support RepeatSupport(const Support& support, Index size) {
  std::vector<EntryRange> ranges = support.ranges();
  for (const EntryRange& range : support.ranges()) ranges.push_back({size + range.begin, size + range.end});
  return Support(std::move(ranges));
}

namespace {

struct BlockPlace {
  std::size_t group = 0;
  Index block = 0;
};

// The block of this size that begins with this parameter, if any.
std::optional<BlockPlace> BlockAt(const std::vector<BlockGroup>& groups, Index parameter, int size) {
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const BlockGroup& group = groups[g];
    const Index from = parameter - group.offset, stride = std::max<Index>(group.block_stride, 1);
    if (group.size == size && from >= 0 && from % stride == 0 && from / stride < group.count)
      return {{g, from / stride}};
  }
  return std::nullopt;
}

// Position of each group's first value among all values.
std::vector<Index> FirstValues(const std::vector<BlockGroup>& groups) {
  std::vector<Index> first;
  first.reserve(groups.size());
  Index at = 0;
  for (const BlockGroup& group : groups) {
    first.push_back(at);
    at += group.NumValues();
  }
  return first;
}

}  // namespace

std::vector<PartSegment> BlockSegments(const std::vector<BlockGroup>& part, const std::vector<BlockGroup>& whole,
                                       const PartMap& tangent) {
  if (tangent.is_identity()) return {};
  std::vector<PartSegment> by_local = tangent.segments();
  std::sort(by_local.begin(), by_local.end(),
            [](const PartSegment& a, const PartSegment& b) { return a.local < b.local; });
  const auto segment_of = [&](Index local) -> const PartSegment& {
    return *(std::upper_bound(by_local.begin(), by_local.end(), local,
                              [](Index at, const PartSegment& s) { return at < s.local; }) -
             1);
  };
  const std::vector<Index> part_first = FirstValues(part), whole_first = FirstValues(whole);
  std::vector<PartSegment> segments;
  for (std::size_t g = 0; g < part.size(); ++g) {
    const BlockGroup& group = part[g];
    for (Index i = 0; i < group.count;) {
      const auto place_of = [&](Index block) {
        const Index local = group.Parameter(block, 0);
        const PartSegment& segment = segment_of(local);
        const auto found = BlockAt(whole, segment.whole + local - segment.local, group.size);
        if (!found) Fail(kBadArgument, "block {} of a part's group {} is not a block of the whole problem", block, g);
        return *found;
      };
      const BlockPlace first = place_of(i);
      Index run = 1;
      // Blocks in one segment have the same spacing in the whole.
      if (group.block_stride > 0 && group.block_stride == whole[first.group].block_stride) {
        const Index begin = group.Parameter(i, 0);
        const PartSegment& segment = segment_of(begin);
        run = std::min({group.count - i, whole[first.group].count - first.block,
                        (segment.local + segment.size - 1 - begin) / group.block_stride + 1});
      }
      for (int value = 0; value < PackedSize(group.size); ++value) {
        segments.push_back({part_first[g] + value * group.count + i,
                            whole_first[first.group] + value * whole[first.group].count + first.block, run});
      }
      i += run;
    }
  }
  return segments;
}

template void PartMap::Take(HostSpan<const float>, HostSpan<float>) const;
template void PartMap::Take(HostSpan<const double>, HostSpan<double>) const;
template HostSpan<const float> PartMap::Local(HostSpan<const float>, HostBuffer<float>&) const;
template HostSpan<const double> PartMap::Local(HostSpan<const double>, HostBuffer<double>&) const;
template void PartMap::MakeCompact(HostSpan<const float>, HostSpan<float>) const;
template void PartMap::MakeCompact(HostSpan<const double>, HostSpan<double>) const;

}  // namespace vesta
