// The views of an iteration of Adam, shared by processes: each takes a run of them, and all hand round what theirs
// tell.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/train/sum_of_views.h"

namespace vesta::gs {

// Those of an iteration's `views` that this process takes; ranks: null for all of them. A single view is everybody's.
inline Share OwnViews(const Ranks* ranks, Index views) {
  return ranks && views > 1 ? ShareOf(views, ranks->size(), ranks->rank()) : Share{0, views};
}

// The next of the views given by next() that is this process's own. place: of the first of them in its iteration; moves
// on.
template <class Next>
std::size_t NextOwn(const Share& own, Index views, Index* place, const Next& next) {
  for (;;) {
    const std::size_t view = next();
    const Index at = (*place)++ % views;
    if (at >= own.begin && at < own.end) return view;
  }
}

// Once each process has added its own views: hands round what they came to, so that the sum has those of all. The bytes
// that a process receives are the terms of the others: a view's are those of the Gaussians that it sees.
// Nothing is done without others, and of a single view.
inline void ShareParts(Ranks* others, SumOfViews<Host>* sum) {
  if (!others || sum->num_views() == 1) return;
  Ranks& ranks = *others;
  struct Piece {
    std::int64_t begin, end, bytes, gaussians;
  };
  std::vector<Piece> pieces;
  std::vector<unsigned char> bytes;
  for (auto& [node, value] : sum->TakeParts()) {
    const HostSpan<const unsigned char> term = value.Bytes();
    pieces.push_back({node.begin, node.end, term.size(), sum->num_gaussians()});
    bytes.insert(bytes.end(), term.begin(), term.end());
  }
  pieces = GatherValues(ranks, pieces);
  bytes = GatherValues(ranks, bytes);
  const unsigned char* at = bytes.data();
  for (const Piece& piece : pieces) {
    // What its blocks are numbered by.
    VESTA_CHECK(piece.gaussians == sum->num_gaussians(), "processes train {} and {} Gaussians", piece.gaussians,
                sum->num_gaussians());
    sum->AddPart({TreeNode{piece.begin, piece.end}, ViewGradient<Host>::FromBytes({at, piece.bytes})});
    at += piece.bytes;
  }
}

}  // namespace vesta::gs
