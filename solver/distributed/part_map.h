// SPDX-License-Identifier: Apache-2.0
// Maps the entries of a part's vectors to entries of the whole problem's vectors.
#pragma once

#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/vector_backend.h"
#include "kernels/ranks/support.h"
#include "solver/distributed/problem_parts.h"

namespace vesta {

// Local vectors have the part's own order. Compact vectors have the same entries in the order of the whole problem
// (kernels/ranks/support.h).
class PartMap {
 public:
  PartMap() = default;
  // No segments means that the part has all entries. Throws Error unless the segments map each of the part's local_size
  // entries once, to different ones of the whole_size entries. what: name of the entries, for the message.
  PartMap(const std::vector<PartSegment>& segments, Index local_size, Index whole_size, const char* what);

  const std::vector<PartSegment>& segments() const { return segments_; }
  const Support& support() const { return support_; }
  Index local_size() const { return local_size_; }
  bool is_identity() const { return is_identity_; }
  // True if local and compact vectors have the same order.
  bool is_compact() const { return is_compact_; }

  // local = the part's entries of whole.
  template <class S>
  void Take(HostSpan<const S> whole, HostSpan<S> local) const;
  // The part's entries of whole: `whole` itself if the part has all of them, else a copy, valid until `storage`
  // changes.
  template <class S>
  HostSpan<const S> Local(HostSpan<const S> whole, HostBuffer<S>& storage) const;
  // compact = the entries of local, in the order of the whole.
  template <class S>
  void MakeCompact(HostSpan<const S> local, HostSpan<S> compact) const;

 private:
  std::vector<PartSegment> segments_;  // sorted by their position in the whole
  Support support_;
  Index local_size_ = 0;
  bool is_identity_ = true, is_compact_ = true;
};

// The support of two consecutive vectors of `size` entries, each with this support.
Support RepeatSupport(const Support& support, Index size);

// Segments for a PartMap that maps the values (BlockDiagonal::all_values) of a part's block-diagonal matrix to the
// whole problem's matrix. tangent: map of the part's step entries. Throws Error if a block of the part is not a block
// of the whole problem.
std::vector<PartSegment> BlockSegments(const std::vector<BlockGroup>& part, const std::vector<BlockGroup>& whole,
                                       const PartMap& tangent);

}  // namespace vesta
