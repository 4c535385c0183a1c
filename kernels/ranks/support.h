// Where the entries of a vector may differ from zero: a sorted list of ranges.
#pragma once

#include <vector>

#include "kernels/core/span.h"

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
  Support Within(Index begin, Index end) const;
  friend Support Union(const Support& a, const Support& b);
  friend bool operator==(const Support&, const Support&) = default;

 private:
  std::vector<EntryRange> ranges_;
  Index size_ = 0;
};

Support Union(const Support& a, const Support& b);

// left += right: compact vectors over a and b. The result is over Union(a, b), in `left` where that is a, else in new
// memory that `left` then owns. What lies outside of one of them is the other's alone.
template <class Vector>
void AddCompact(const Support& a, Vector& left, const Support& b, const Vector& right, const Support& both);
// whole, a vector of all entries, becomes a compact one with zeros elsewhere.
template <class S>
void Spread(const Support& support, HostSpan<const S> compact, HostSpan<S> whole);

}  // namespace vesta
