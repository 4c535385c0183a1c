// SPDX-License-Identifier: Apache-2.0
// Where the entries of a part's vectors lie in those of the whole.
#pragma once

#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/vector_backend.h"
#include "kernels/ranks/support.h"
#include "solver/distributed/problem_parts.h"

namespace vesta {

// A compact vector of the part is in the order of the whole (kernels/ranks/support.h); the part's own order may be
// another.
class PartMap {
 public:
  PartMap() = default;
  // No segments: the part has all entries. Throws Error, naming `what`, where they are not local_size entries of
  // whole_size, each once.
  PartMap(const std::vector<PartSegment>& segments, Index local_size, Index whole_size, const char* what);

  const std::vector<PartSegment>& segments() const { return segments_; }
  const Support& support() const { return support_; }
  Index local_size() const { return local_size_; }
  bool is_identity() const { return is_identity_; }
  // Whether the part's own order is that of the whole.
  bool is_compact() const { return is_compact_; }

  // local = the part's entries of whole.
  template <class S>
  void Take(HostSpan<const S> whole, HostSpan<S> local) const;
  // The part's entries of whole: whole itself where it has all, else in `room`, for as long as that stays as it is.
  template <class S>
  HostSpan<const S> Local(HostSpan<const S> whole, HostBuffer<S>& room) const;
  template <class S>
  void MakeCompact(HostSpan<const S> local, HostSpan<S> compact) const;

 private:
  std::vector<PartSegment> segments_;  // by their place in the whole
  Support support_;
  Index local_size_ = 0;
  bool is_identity_ = true, is_compact_ = true;
};

// The entries of two vectors of so many entries, one after the other, where each has these.
Support TwiceOver(const Support& support, Index size);

// Where the values of a part's block-diagonal matrix lie in the whole's (BlockDiagonal::all_values), for PartMap.
// Throws Error where a block of the part is none of the whole.
std::vector<PartSegment> BlockSegments(const std::vector<BlockGroup>& part, const std::vector<BlockGroup>& whole,
                                       const PartMap& tangent);

}  // namespace vesta
