// SPDX-License-Identifier: Apache-2.0
// Correlation of an image with a separable kernel of kTaps x kTaps, the one loop of this problem: a blur is the
// correlation of the image, in a frame of zeros, with the kernel turned round; its adjoint that with the kernel itself.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"
#include "bench/deconvolution/coded_apertures.h"

namespace vesta::deconvolution {

// out(i, j) = sum_pq column[p] row[q] in(i + p, j + q) for the rows i within [begin, end) and 0 <= j < width. With
// accumulate it is added to out.
struct CorrelationArgs {
  const double* in = nullptr;  // rows of in_stride >= width + kSpill; kCorrelationSlack more can be read
  double* out = nullptr;       // rows of width
  Index in_stride = 0, width = 0;
  bool accumulate = false;
  double column[kTaps] = {}, row[kTaps] = {};
};
// The widest vector, in doubles: reads may go beyond the last row by so much, less one.
inline constexpr Index kCorrelationSlack = 8;

using CorrelateRows = void (*)(const CorrelationArgs& args, Index begin, Index end);
// Compiled for an instruction set that the CPU has.
CorrelateRows CorrelateRowsFor(Isa isa);

}  // namespace vesta::deconvolution
