// SPDX-License-Identifier: Apache-2.0
// Exchange of gradients between processes, as the bytes of terms. A term is the block-sparse gradient of one view, or
// the sum of several (sum_of_views.h).
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/core/check.h"
#include "kernels/core/span.h"
#include "splatting/distributed/process_group.h"
#include "splatting/distributed/view_gradient_steps.h"

namespace vesta::gs {

// Cost of one view, or of all views of a term.
struct ViewCost {
  double objective = 0;  // photometric loss
  double values = 0;     // pixels times channels
};

namespace term {

// The start of a term. The block numbers, the first row of each block, and the rows (term::Arrays) follow; each of
// these arrays starts at a multiple of kAlignment bytes.
struct Header {
  ViewCost cost;
  Index blocks = 0, rows = 0;
};
inline constexpr Index kAlignment = 64, kHeaderBytes = kAlignment;
static_assert(sizeof(Header) <= kHeaderBytes);

// Sizes and positions of the arrays in a term, bytes.
constexpr Index ListBytes(Index blocks) {
  return (blocks * static_cast<Index>(sizeof(std::uint32_t)) + kAlignment - 1) / kAlignment * kAlignment;
}
constexpr Index BlockAt() { return kHeaderBytes; }
constexpr Index BeginAt(Index blocks) { return kHeaderBytes + ListBytes(blocks); }
constexpr Index RowsAt(Index blocks) { return kHeaderBytes + 2 * ListBytes(blocks); }
constexpr Index RowBytes(Index rows) { return rows * kLanes * static_cast<Index>(sizeof(float)); }
constexpr Index SizeOf(const Header& header) { return RowsAt(header.blocks) + RowBytes(header.rows); }

// Writes the header, and sets the padding of the term to zero.
inline void WriteHeader(const Header& header, unsigned char* to) {
  std::fill_n(to, kHeaderBytes, static_cast<unsigned char>(0));
  std::memcpy(to, &header, sizeof(header));
  const Index used = header.blocks * static_cast<Index>(sizeof(std::uint32_t)),
              unused = ListBytes(header.blocks) - used;
  for (const Index list : {BlockAt(), BeginAt(header.blocks)}) {
    std::fill_n(to + list + used, unused, static_cast<unsigned char>(0));
  }
}
// Throws Error if the bytes are not a term.
inline Header ReadHeader(HostSpan<const unsigned char> bytes) {
  Header header;
  const bool has_header = bytes.size() >= kHeaderBytes;
  if (has_header) std::memcpy(&header, bytes.data(), sizeof(header));
  if (!has_header || header.blocks < 0 || header.rows < 0 || SizeOf(header) != bytes.size()) {
    Fail(kUnavailable, "{} bytes received are not the gradient of a view; the message was truncated", bytes.size());
  }
  return header;
}

}  // namespace term

// All-gather of the gradients of an Adam iteration: each process computes the gradients of some consecutive views, and
// receives all. Keeps its memory between iterations.
class TermExchange {
 public:
  // Collective. Each process has added its own views to `sum`, a SumOfViews on the host (sum_of_views.h). Afterwards
  // `sum` has all views on every process, with the same bits as if one process computed all.
  template <class Sum>
  void AllGather(Communicator& ranks, Sum* sum) {
    const auto self = static_cast<std::size_t>(ranks.rank()), size = static_cast<std::size_t>(ranks.size());
    auto parts = sum->TakeParts();
    std::vector<HostSpan<const unsigned char>> pieces;
    std::vector<Part> all_parts;
    std::vector<std::size_t> sizes(size);
    for (auto& [node, term] : parts) {
      pieces.push_back(term.Bytes());
      all_parts.push_back({ranks.rank(), node.begin, node.end, sum->num_gaussians(), pieces.back().size()});
    }
    all_parts = GatherValues(ranks, all_parts);
    for (const Part& part : all_parts) {
      VESTA_CHECK(part.gaussians == sum->num_gaussians(), "processes have {} and {} Gaussians", part.gaussians,
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
    for (const Part& part : all_parts) {
      if (part.rank != ranks.rank()) sum->AddPart({part.begin, part.end}, {at, part.bytes});
      at += part.bytes;
    }
  }

 private:
  // Description of a partial sum, sent to every process: the rank that computed the sum, its views [begin, end), the
  // number of Gaussians, and the size of the sum in bytes.
  struct Part {
    Index rank, begin, end, gaussians, bytes;
  };

  // Allocates a quarter more, since the size differs slightly between iterations.
  void Reserve(Index bytes) {
    if (bytes_.capacity() < bytes) bytes_.ResizeForOverwrite(bytes + bytes / 4);
    bytes_.ResizeForOverwrite(bytes);
  }

  HostBuffer<unsigned char> bytes_;
};

}  // namespace vesta::gs
