// SPDX-License-Identifier: Apache-2.0
// The bytes of a term of a gradient (view_gradient.h).
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "kernels/core/check.h"
#include "kernels/core/span.h"
#include "splatting/distributed/view_gradient_steps.h"

namespace vesta::gs {

// Sums over the views of a term.
struct ViewCost {
  double objective = 0;  // of the photometric loss
  double values = 0;     // pixels times channels
};

namespace term {

// What a term begins with. Then come the numbers of its blocks, the row that each begins with, and the rows, each from
// a multiple of kAlignment bytes on.
struct Header {
  ViewCost cost;
  Index blocks = 0, rows = 0;
};
inline constexpr Index kAlignment = 64, kHeaderBytes = kAlignment;
static_assert(sizeof(Header) <= kHeaderBytes);

constexpr Index ListBytes(Index blocks) {
  return (blocks * static_cast<Index>(sizeof(std::uint32_t)) + kAlignment - 1) / kAlignment * kAlignment;
}
constexpr Index BlockAt() { return kHeaderBytes; }
constexpr Index BeginAt(Index blocks) { return kHeaderBytes + ListBytes(blocks); }
constexpr Index RowsAt(Index blocks) { return kHeaderBytes + 2 * ListBytes(blocks); }
constexpr Index RowBytes(Index rows) { return rows * kLanes * static_cast<Index>(sizeof(float)); }
constexpr Index SizeOf(const Header& header) { return RowsAt(header.blocks) + RowBytes(header.rows); }

// Of a term that lies at `to`, the header, and zeros where there is nothing.
inline void WriteHeader(const Header& header, unsigned char* to) {
  std::fill_n(to, kHeaderBytes, static_cast<unsigned char>(0));
  std::memcpy(to, &header, sizeof(header));
  const Index used = header.blocks * static_cast<Index>(sizeof(std::uint32_t)),
              unused = ListBytes(header.blocks) - used;
  for (const Index list : {BlockAt(), BeginAt(header.blocks)}) {
    std::fill_n(to + list + used, unused, static_cast<unsigned char>(0));
  }
}
// Throws Error where these are not the bytes of a term.
inline Header ReadHeader(HostSpan<const unsigned char> bytes) {
  Header header;
  const bool has_header = bytes.size() >= kHeaderBytes;
  if (has_header) std::memcpy(&header, bytes.data(), sizeof(header));
  if (!has_header || header.blocks < 0 || header.rows < 0 || SizeOf(header) != bytes.size()) {
    Fail(kUnavailable, "{} bytes are not the gradient of a view: they were cut short on their way", bytes.size());
  }
  return header;
}

}  // namespace term
}  // namespace vesta::gs
