// SPDX-License-Identifier: Apache-2.0
// The support of a vector: the entries that may differ from zero, as a sorted list of ranges.
#pragma once

#include <vector>

#include "kernels/core/buffer.h"

namespace vesta {

// The entries begin .. end - 1.
struct EntryRange {
  Index begin = 0, end = 0;
  Index size() const { return end - begin; }
  friend bool operator==(const EntryRange&, const EntryRange&) = default;
};

// Ascending, non-empty ranges with gaps between them. The values of a vector at these entries, in this order, form its
// compact vector of size() elements.
class Support {
 public:
  Support() = default;
  // Ranges may be in any order, empty, or overlapping.
  explicit Support(std::vector<EntryRange> ranges);
  static Support All(Index size) { return Support({{0, size}}); }

  const std::vector<EntryRange>& ranges() const { return ranges_; }
  Index size() const { return size_; }
  bool IsAll(Index size) const { return size_ == size; }
  // Number of entries of the support that are less than `entry`.
  Index CountBefore(Index entry) const;
  friend bool operator==(const Support&, const Support&) = default;

 private:
  std::vector<EntryRange> ranges_;
  Index size_ = 0;
};

Support Union(const Support& a, const Support& b);
Support Intersection(const Support& a, const Support& b);
// Positions, in a compact vector over `in`, of the entries in both supports, as ascending ranges with gaps between
// them.
std::vector<EntryRange> PositionsIn(const Support& entries, const Support& in);

// left += right. On entry, `left` is a compact vector over a, and `right` over b. On return, `left` is one over `both`,
// the union of a and b. spare: scratch memory.
template <class S>
void AddCompact(const Support& a, HostBuffer<S>& left, const Support& b, HostSpan<const S> right, const Support& both,
                HostBuffer<S>& spare);
// Writes the compact vector to the entries of the support in `whole`, and zero to all others.
template <class S>
void Expand(const Support& support, HostSpan<const S> compact, HostSpan<S> whole);

}  // namespace vesta
