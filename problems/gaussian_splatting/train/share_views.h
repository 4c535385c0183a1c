// The views of an iteration of Adam, shared by processes: each takes a run of them, and all hand round what theirs
// tell.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/train/sum_of_views.h"

namespace vesta::gs {

// Those of an iteration's `views` that this process takes; ranks: null for all of them. A single view is everybody's.
inline Share OwnViews(const Ranks* ranks, Index views) {
  return ranks && views > 1 ? ShareOf(views, ranks->size(), ranks->rank()) : Share{0, views};
}

// Once each process has added its own views: hands round what they came to, so that the sum has those of all. The bytes
// that a process receives are the terms of the others: a view's are those of the Gaussians that it sees.
inline void ShareParts(Ranks& ranks, SumOfViews<Host>* sum) {
  struct Piece {
    std::int64_t begin, end, bytes;
  };
  std::vector<Piece> pieces;
  std::vector<unsigned char> bytes;
  for (auto& [node, value] : sum->TakeParts()) {
    const HostSpan<const unsigned char> term = value.Bytes();
    pieces.push_back({node.begin, node.end, term.size()});
    bytes.insert(bytes.end(), term.begin(), term.end());
  }
  pieces = GatherValues(ranks, pieces);
  bytes = GatherValues(ranks, bytes);
  const unsigned char* at = bytes.data();
  for (const Piece& piece : pieces) {
    sum->AddPart({TreeNode{piece.begin, piece.end}, ViewGradient<Host>::FromBytes({at, piece.bytes})});
    at += piece.bytes;
  }
}

}  // namespace vesta::gs
