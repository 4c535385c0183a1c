// SPDX-License-Identifier: Apache-2.0
#include "kernels/ranks/support.h"

#include <algorithm>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/vector_backend.h"

namespace vesta {

Support::Support(std::vector<EntryRange> ranges) {
  std::sort(ranges.begin(), ranges.end(), [](const EntryRange& a, const EntryRange& b) { return a.begin < b.begin; });
  for (const EntryRange& range : ranges) {
    if (range.size() <= 0) continue;
    if (!ranges_.empty() && range.begin <= ranges_.back().end) {
      ranges_.back().end = std::max(ranges_.back().end, range.end);
    } else {
      ranges_.push_back(range);
    }
  }
  for (const EntryRange& range : ranges_) size_ += range.size();
}

Index Support::CountBefore(Index entry) const {
  Index count = 0;
  for (const EntryRange& range : ranges_) {
    if (range.begin >= entry) break;
    count += std::min(range.end, entry) - range.begin;
  }
  return count;
}

Support Union(const Support& a, const Support& b) {
  std::vector<EntryRange> ranges = a.ranges();
  ranges.insert(ranges.end(), b.ranges().begin(), b.ranges().end());
  return Support(std::move(ranges));
}

Support Intersection(const Support& a, const Support& b) {
  std::vector<EntryRange> ranges;
  auto other = b.ranges().begin();
  for (const EntryRange& range : a.ranges()) {
    while (other != b.ranges().end() && other->end <= range.begin) ++other;
    for (auto at = other; at != b.ranges().end() && at->begin < range.end; ++at) {
      ranges.push_back({std::max(range.begin, at->begin), std::min(range.end, at->end)});
    }
  }
  return Support(std::move(ranges));
}

std::vector<EntryRange> PositionsIn(const Support& entries, const Support& in) {
  std::vector<EntryRange> places;
  Index before = 0;  // total size of the ranges of `in` before `range`
  auto range = in.ranges().begin();
  const Support both = Intersection(entries, in);
  for (const EntryRange& part : both.ranges()) {
    for (; range->end < part.end; ++range) before += range->size();
    const Index begin = before + part.begin - range->begin;
    if (!places.empty() && places.back().end == begin) {
      places.back().end += part.size();
    } else {
      places.push_back({begin, begin + part.size()});
    }
  }
  return places;
}

namespace {

// Calls body(entries of `to`, entries of `from`) for each range of `part`. `from` is compact over `part`, `to` over
// `both`.
template <class S, class Body>
void ForRuns(const Support& part, HostSpan<const S> from, const Support& both, HostSpan<S> to, const Body& body) {
  Index from_at = 0, to_before = 0;
  std::size_t k = 0;
  for (const EntryRange& range : part.ranges()) {
    while (both.ranges()[k].end < range.end) to_before += both.ranges()[k++].size();
    const Index to_at = to_before + range.begin - both.ranges()[k].begin;
    body(to.subspan(to_at, range.size()), from.subspan(from_at, range.size()));
    from_at += range.size();
  }
}

}  // namespace

template <class S>
void AddCompact(const Support& a, HostBuffer<S>& left, const Support& b, HostSpan<const S> right, const Support& both,
                HostBuffer<S>& spare) {
  CpuBackend<S> backend;
  VESTA_CHECK(left.size() == a.size() && right.size() == b.size(),
              "vectors of {} and {} entries, but supports of {} and {}", left.size(), right.size(), a.size(), b.size());
  if (both.size() != a.size()) {
    spare.Resize(both.size());
    ForRuns<S>(a, std::as_const(left).view(), both, spare.view(),
               [&](HostSpan<S> to, HostSpan<const S> from) { backend.Copy(from, to); });
    std::swap(left, spare);
  }
  ForRuns<S>(b, right, both, left.view(),
             [&](HostSpan<S> to, HostSpan<const S> from) { backend.Axpby(1.0, from, 1.0, to); });
}

template <class S>
void Expand(const Support& support, HostSpan<const S> compact, HostSpan<S> whole) {
  CpuBackend<S> backend;
  if (!support.IsAll(whole.size())) backend.Fill(0, whole);
  Index at = 0;
  for (const EntryRange& range : support.ranges()) {
    backend.Copy(compact.subspan(at, range.size()), whole.subspan(range.begin, range.size()));
    at += range.size();
  }
}

template void AddCompact(const Support&, HostBuffer<float>&, const Support&, HostSpan<const float>, const Support&,
                         HostBuffer<float>&);
template void AddCompact(const Support&, HostBuffer<double>&, const Support&, HostSpan<const double>, const Support&,
                         HostBuffer<double>&);
template void Expand(const Support&, HostSpan<const float>, HostSpan<float>);
template void Expand(const Support&, HostSpan<const double>, HostSpan<double>);

}  // namespace vesta
