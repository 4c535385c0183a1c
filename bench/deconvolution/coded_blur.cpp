// SPDX-License-Identifier: Apache-2.0
#include "bench/deconvolution/coded_blur.h"

#include <algorithm>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::deconvolution {
namespace {

constexpr Index kBandRows = 16;

Aperture Turned(Aperture aperture) {
  std::reverse(aperture.column.begin(), aperture.column.end());
  std::reverse(aperture.row.begin(), aperture.row.end());
  return aperture;
}

Aperture Squared(Aperture aperture) {
  for (Code* code : {&aperture.column, &aperture.row}) {
    for (double& tap : *code) tap *= tap;
  }
  return aperture;
}

}  // namespace

CodedBlur::CodedBlur(Index side, std::vector<Aperture> apertures)
    : side_(side), apertures_(std::move(apertures)), correlate_rows_(CorrelateRowsFor(ActiveIsa())) {
  if (side < 1) Fail(kBadArgument, "an image of {} x {} pixels; choose 1 or more", side, side);
  for (const Aperture& aperture : apertures_) {
    turned_.push_back(Turned(aperture));
    squared_.push_back(Squared(aperture));
  }
  padded_image_.Resize((side_ + 2 * kSpill) * (side_ + 2 * kSpill) + kCorrelationSlack);
  frame_.Resize(frame_size() + kCorrelationSlack);
}

void CodedBlur::Correlate(CorrelationArgs args, const Aperture& aperture, Index rows) const {
  std::copy(aperture.column.begin(), aperture.column.end(), args.column);
  std::copy(aperture.row.begin(), aperture.row.end(), args.row);
  ParallelForChunks(rows, kBandRows, [&](Index begin, Index end) { correlate_rows_(args, begin, end); });
}

void CodedBlur::Blur(int frame, HostSpan<double> out) {
  VESTA_CHECK(out.size() == frame_size(), "a frame of {} values, not {}", frame_size(), out.size());
  Correlate({.in = padded_image_.data(), .out = out.data(), .in_stride = side_ + 2 * kSpill, .width = frame_side()},
            turned_[static_cast<std::size_t>(frame)], frame_side());
}

void CodedBlur::Accumulate(const Aperture& aperture, bool first, HostSpan<double> out) const {
  VESTA_CHECK(out.size() == image_size(), "an image of {} values, not {}", image_size(), out.size());
  Correlate({.in = frame_.data(), .out = out.data(), .in_stride = frame_side(), .width = side_, .accumulate = !first},
            aperture, side_);
}

}  // namespace vesta::deconvolution
