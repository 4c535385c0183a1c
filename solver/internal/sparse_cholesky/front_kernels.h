// SPDX-License-Identifier: Apache-2.0
// Dense kernels of the multifrontal Cholesky factorisation, compiled once per instruction set. Plain pointers: this is
// the seam between *.simd.cpp and the class that owns memory and threads (block_cholesky.h).
//
// A panel holds the first `pivots` columns of a front of `rows` rows, column-major with stride `stride`, its lower
// trapezoid valid: what lies above the diagonal is written to and means nothing.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"

namespace vesta {

// Panels and updates are padded by rows that the kernels read and write: strides are at least PaddedRows.
constexpr Index kFrontPad = 8;
constexpr Index PaddedRows(Index rows) { return (rows + kFrontPad - 1) / kFrontPad * kFrontPad + kFrontPad; }

// Columns are taken in strips of so many, or fewer: that is how far above the diagonal the kernels reach, up to the
// next whole batch of kFrontPad.
constexpr Index kFrontStrip = 6;

struct FrontPanel {
  double* values;
  Index stride, rows, pivots;
};

struct FrontKernels {
  // Replaces the panel by the columns of the Cholesky factor. A pivot that is not above its entry of least (pivots
  // values >= 0) is raised to that, or to 1 where that is 0; returns the number of those.
  Index (*factorize)(const FrontPanel& panel, const double* least);
  // update -= L2 L2^T, L2 the factorised panel's rows below its pivots: columns begin..end of the update's
  // lower triangle.
  void (*subtract_outer)(const FrontPanel& panel, double* update, Index update_stride, Index begin, Index end);
  // One front's part of solving L y = x: x[0..pivots) is replaced, its effect subtracted from x[pivots..rows).
  void (*forward)(const FrontPanel& panel, double* x);
  // One front's part of solving L^T y = x: x[0..pivots) is replaced, x[pivots..rows) read.
  void (*backward)(const FrontPanel& panel, double* x);
};

// Compiled for an instruction set that the CPU has.
const FrontKernels& FrontKernelsFor(Isa isa);

}  // namespace vesta
