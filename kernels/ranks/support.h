// SPDX-License-Identifier: Apache-2.0
// Where the entries of a vector may differ from zero: a sorted list of ranges.
#pragma once

#include <vector>

#include "kernels/core/buffer.h"

namespace vesta {

// Entries begin .. end - 1.
struct EntryRange {
  Index begin = 0, end = 0;
  Index size() const { return end - begin; }
  friend bool operator==(const EntryRange&, const EntryRange&) = default;
};

// Ascending, none empty, none touching the next. The entries within, in this order, are a compact vector of size().
class Support {
 public:
  Support() = default;
  // In any order, of any size, and they may overlap.
  explicit Support(std::vector<EntryRange> ranges);
  static Support All(Index size) { return Support({{0, size}}); }

  const std::vector<EntryRange>& ranges() const { return ranges_; }
  Index size() const { return size_; }
  bool IsAll(Index size) const { return size_ == size; }
  // How many of its entries lie before this one.
  Index CountBefore(Index entry) const;
  friend bool operator==(const Support&, const Support&) = default;

 private:
  std::vector<EntryRange> ranges_;
  Index size_ = 0;
};

Support Union(const Support& a, const Support& b);
Support Intersection(const Support& a, const Support& b);
// Of the entries of both, where they lie in a compact vector over `in`: ascending, none touching the next.
std::vector<EntryRange> PlacesIn(const Support& entries, const Support& in);

// left += right: compact vectors over a and b, `both` their union. Where that is more than a, `left` and `spare` change
// places, and the sum is in what was `spare`. What lies outside of one of them is the other's alone.
template <class S>
void AddCompact(const Support& a, HostBuffer<S>& left, const Support& b, HostSpan<const S> right, const Support& both,
                HostBuffer<S>& spare);
// whole = the compact vector at its entries, zeros elsewhere.
template <class S>
void Spread(const Support& support, HostSpan<const S> compact, HostSpan<S> whole);

}  // namespace vesta
