// SPDX-License-Identifier: Apache-2.0
// Correlation of an image with a separable kernel of kTaps x kTaps. A blur is the correlation of the zero-padded image
// with the flipped kernel; its adjoint is the correlation with the kernel itself.
#pragma once

#include "bench/deconvolution/coded_apertures.h"
#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"

namespace vesta::deconvolution {

// out(i, j) = sum_pq column[p] row[q] in(i + p, j + q) for the rows i in [begin, end) and 0 <= j < width. With
// `accumulate` the sum is added to out.
struct CorrelationArgs {
  const double* in = nullptr;  // rows of in_stride >= width + kSpill; kCorrelationSlack more values must be readable
  double* out = nullptr;       // rows of width
  Index in_stride = 0, width = 0;
  bool accumulate = false;
  double column[kTaps] = {}, row[kTaps] = {};
};
// Width of the widest vector, in doubles. Reads may pass the end of the last row by this number minus one.
inline constexpr Index kCorrelationSlack = 8;

using CorrelateRows = void (*)(const CorrelationArgs& args, Index begin, Index end);
// The function compiled for this instruction set, which the CPU must support.
CorrelateRows CorrelateRowsFor(Isa isa);

}  // namespace vesta::deconvolution
