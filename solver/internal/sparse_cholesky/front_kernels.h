// SPDX-License-Identifier: Apache-2.0
// Dense kernels of the multifrontal Cholesky factorisation, compiled once per instruction set. They use plain pointers.
// block_cholesky.h owns the memory and the threads.
//
// A panel holds the first `pivots` columns of a front of `rows` rows, column-major with stride `stride`. Its lower
// trapezoid is valid. Values above the diagonal are overwritten and have no meaning.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"

namespace vesta {

// Kernels access padding rows of panels and updates, so every stride is at least PaddedRows.
constexpr Index kFrontPad = 8;
constexpr Index PaddedRows(Index rows) { return (rows + kFrontPad - 1) / kFrontPad * kFrontPad + kFrontPad; }

// Kernels process up to this many columns at a time. So they access values this far above the diagonal, rounded up to a
// multiple of kFrontPad.
constexpr Index kFrontStrip = 6;

struct FrontPanel {
  double* values;
  Index stride, rows, pivots;
};

struct FrontKernels {
  // Replaces the panel by the columns of the Cholesky factor. `least` has `pivots` values >= 0. A pivot that is not
  // above its value is raised to it, or to 1 if the value is 0. Returns the number of raised pivots.
  Index (*factorize)(const FrontPanel& panel, const double* least);
  // update -= L2 L2^T in columns begin..end of the update's lower triangle. L2 holds the factorised panel's rows below
  // its pivots.
  void (*subtract_outer)(const FrontPanel& panel, double* update, Index update_stride, Index begin, Index end);
  // One front's part of solving L y = x. Replaces x[0..pivots) and subtracts their effect from x[pivots..rows).
  void (*forward)(const FrontPanel& panel, double* x);
  // One front's part of solving L^T y = x. Replaces x[0..pivots) and reads x[pivots..rows).
  void (*backward)(const FrontPanel& panel, double* x);
};

// Returns the kernels for an instruction set that the CPU supports.
const FrontKernels& FrontKernelsFor(Isa isa);

}  // namespace vesta
