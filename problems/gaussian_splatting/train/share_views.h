// The views of an iteration of Adam, shared by processes: each takes a run of them, and all hand round what theirs
// tell.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/model/view_owners.h"
#include "problems/gaussian_splatting/train/sum_of_views.h"

namespace vesta::gs {

// Which training views this process takes of iterations of so many.
class OwnViewsOfIterations {
 public:
  // ranks: null for a process alone. A single view at a time is everybody's.
  OwnViewsOfIterations(const Ranks* ranks, int at_once, std::size_t views)
      : own_(OwnTrainingViews(at_once > 1 ? ranks : nullptr, static_cast<Index>(views))) {}

  bool Has(std::size_t view) const {
    return static_cast<Index>(view) >= own_.begin && static_cast<Index>(view) < own_.end;
  }
  const Share& share() const { return own_; }
  bool empty() const { return own_.size() == 0; }
  // The k-th of `of` of them, about as far from one another.
  std::size_t At(std::size_t k, std::size_t of) const {
    return static_cast<std::size_t>(own_.begin) + k * static_cast<std::size_t>(own_.size()) / of;
  }
  // The next of those that next() gives.
  template <class Next>
  std::size_t NextOf(const Next& next) const {
    std::size_t view = next();
    while (!Has(view)) view = next();
    return view;
  }
  std::size_t size() const { return static_cast<std::size_t>(own_.size()); }

 private:
  Share own_;
};

// Hands round what the views of an iteration came to, and keeps the memory for that.
class ViewExchange {
 public:
  // Once each process has added its own views: then the sum has those of all. The bytes that a process receives are the
  // terms of the others: a view's are those of the Gaussians that it sees. Those of a device come and go through the
  // host's memory. Nothing is done without others, and of a single view.
  template <class Space>
  void Share(Ranks* others, SumOfViews<Space>* sum) {
    if (!others || others->size() == 1 || sum->num_views() == 1) return;
    Ranks& ranks = *others;
    auto own = sum->TakeParts();
    std::vector<Piece> pieces;
    pieces.reserve(own.size());
    for (auto& [node, value] : own) pieces.push_back({ranks.rank(), node, value.NumBytes(), sum->num_gaussians()});
    pieces = GatherValues(ranks, pieces);
    std::vector<std::size_t> counts(static_cast<std::size_t>(ranks.size()));
    Index total = 0, before = 0;
    for (const Piece& piece : pieces) {
      // What its blocks are numbered by.
      VESTA_CHECK(piece.gaussians == sum->num_gaussians(), "processes train {} and {} Gaussians", piece.gaussians,
                  sum->num_gaussians());
      counts[static_cast<std::size_t>(piece.rank)] += static_cast<std::size_t>(piece.bytes);
      total += piece.bytes;
      if (piece.rank < ranks.rank()) before += piece.bytes;
    }
    // With some room, since each iteration has a little more or less than the last.
    if (bytes_.size() < total) bytes_.ResizeForOverwrite(total + total / 4);
    for (auto& [node, value] : own) {
      value.WriteBytes({bytes_.data() + before, value.NumBytes()});
      before += value.NumBytes();
      sum->AddPart({node, std::move(value)});
    }
    GatherInto(ranks, std::span(bytes_.data(), static_cast<std::size_t>(total)), counts);
    const unsigned char* at = bytes_.data();
    for (const Piece& piece : pieces) {
      if (piece.rank != ranks.rank()) sum->AddPart(piece.node, {at, piece.bytes});
      at += piece.bytes;
    }
  }

 private:
  struct Piece {
    int rank;
    TreeNode node;
    std::int64_t bytes, gaussians;
  };
  HostBuffer<unsigned char> bytes_;  // of all
};

}  // namespace vesta::gs
