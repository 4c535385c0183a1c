// SPDX-License-Identifier: Apache-2.0
// The views of an iteration of Adam, shared by processes: each takes a run of them, and all get all gradients.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/core/check.h"
#include "splatting/distributed/process_group.h"

namespace vesta::gs {

// Keeps its memory from one iteration to the next.
class TermExchange {
 public:
  // Collective, once each process has added its own views to the sum (distributed/sum_of_views.h, on the host): then
  // the sum is that of all views, on every process, to the same bits as where one process has added them all.
  template <class Sum>
  void AllGather(Ranks& ranks, Sum* sum) {
    const auto self = static_cast<std::size_t>(ranks.rank()), size = static_cast<std::size_t>(ranks.size());
    auto parts = sum->TakeParts();
    std::vector<HostSpan<const unsigned char>> pieces;
    std::vector<Part> told;
    std::vector<std::size_t> sizes(size);
    for (auto& [node, term] : parts) {
      pieces.push_back(term.Bytes());
      told.push_back({ranks.rank(), node.begin, node.end, sum->num_gaussians(), pieces.back().size()});
    }
    told = GatherValues(ranks, told);
    for (const Part& part : told) {
      VESTA_CHECK(part.gaussians == sum->num_gaussians(), "processes train {} and {} Gaussians", part.gaussians,
                  sum->num_gaussians());
      sizes[static_cast<std::size_t>(part.rank)] += static_cast<std::size_t>(part.bytes);
    }
    Index before = 0, total = 0;
    for (std::size_t r = 0; r < size; ++r) {
      if (r < self) before += static_cast<Index>(sizes[r]);
      total += static_cast<Index>(sizes[r]);
    }
    Reserve(total);
    unsigned char* to = bytes_.data() + before;
    for (const auto& piece : pieces) to = std::copy_n(piece.data(), piece.size(), to);
    GatherInto(ranks, std::span(bytes_.data(), static_cast<std::size_t>(total)), sizes);
    for (auto& part : parts) sum->AddPart(std::move(part));
    const unsigned char* at = bytes_.data();
    for (const Part& part : told) {
      if (part.rank != ranks.rank()) sum->AddPart({part.begin, part.end}, {at, part.bytes});
      at += part.bytes;
    }
  }

 private:
  // What all processes are told of a part: who has it, its node of the tree, and how large it is.
  struct Part {
    Index rank, begin, end, gaussians, bytes;
  };

  // With some room, since each iteration has a little more or less than the last.
  void Reserve(Index bytes) {
    if (bytes_.capacity() < bytes) bytes_.ResizeForOverwrite(bytes + bytes / 4);
    bytes_.ResizeForOverwrite(bytes);
  }

  HostBuffer<unsigned char> bytes_;
};

}  // namespace vesta::gs
