// SPDX-License-Identifier: Apache-2.0
// Maps the entries of a part's vectors to entries of the whole problem's vectors.
#pragma once

#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/vector_backend.h"
#include "kernels/ranks/support.h"
#include "solver/distributed/problem_parts.h"

namespace vesta {

// The part's own vectors may have any order. Its compact vectors (kernels/ranks/support.h) have the order of the whole.
class PartMap {
 public:
  PartMap() = default;
  // An empty list of segments means that the part has all entries. Throws Error, naming `what`, unless the segments
  // cover local_size entries out of whole_size, each once.
  PartMap(const std::vector<PartSegment>& segments, Index local_size, Index whole_size, const char* what);

  const std::vector<PartSegment>& segments() const { return segments_; }
  const Support& support() const { return support_; }
  Index local_size() const { return local_size_; }
  bool is_identity() const { return is_identity_; }
  // True if the part's own order is the whole's.
  bool is_compact() const { return is_compact_; }

  // local = the part's entries of whole.
  template <class S>
  void Take(HostSpan<const S> whole, HostSpan<S> local) const;
  // Returns the part's entries of whole: `whole` itself if the part has all of them, else a copy in `storage`. The copy
  // is valid until `storage` changes.
  template <class S>
  HostSpan<const S> Local(HostSpan<const S> whole, HostBuffer<S>& storage) const;
  template <class S>
  void MakeCompact(HostSpan<const S> local, HostSpan<S> compact) const;

 private:
  std::vector<PartSegment> segments_;  // sorted by their position in the whole
  Support support_;
  Index local_size_ = 0;
  bool is_identity_ = true, is_compact_ = true;
};

// Support of two vectors of `size` entries stored one after the other, if each has this support.
Support RepeatSupport(const Support& support, Index size);

// Segments that map the values of a part's block-diagonal matrix to the whole's values (BlockDiagonal::all_values), for
// PartMap. Throws Error if a block of the part is not a block of the whole.
std::vector<PartSegment> BlockSegments(const std::vector<BlockGroup>& part, const std::vector<BlockGroup>& whole,
                                       const PartMap& tangent);

}  // namespace vesta
