// SPDX-License-Identifier: Apache-2.0
// Correlation of an image with a separable kernel of kTaps x kTaps values, compiled for each instruction set. A blur is
// the correlation of the zero-padded image with the flipped kernel. Its adjoint is the correlation of the frame with
// the kernel itself.
#pragma once

#include "bench/deconvolution/coded_apertures.h"
#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"

namespace vesta::deconvolution {

// out(i, j) = sum_pq column[p] row[q] in(i + p, j + q) for the rows i in [begin, end) and 0 <= j < width. If
// `accumulate`, out += this sum.
struct CorrelationArgs {
  // Rows of in_stride >= width + kSpill values; kCorrelationSlack more values after the last row must be readable.
  const double* in = nullptr;
  double* out = nullptr;  // rows of `width` values
  Index in_stride = 0, width = 0;
  bool accumulate = false;
  double column[kTaps] = {}, row[kTaps] = {};
};
// Width of the widest SIMD vector, in doubles. Up to this number minus one values after the last row are read.
inline constexpr Index kCorrelationSlack = 8;

using CorrelateRows = void (*)(const CorrelationArgs& args, Index begin, Index end);
// For this instruction set, which the CPU must support.
CorrelateRows CorrelateRowsFor(Isa isa);

}  // namespace vesta::deconvolution
