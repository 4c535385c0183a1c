// SPDX-License-Identifier: Apache-2.0
// Dense kernels of the multifrontal Cholesky factorisation, compiled once per instruction set. block_cholesky.h owns
// the memory and the threads.
//
// A front is a small symmetric dense matrix whose first `pivots` columns are eliminated (elimination.h). Its panel is
// these columns, with all `rows` rows, column-major with stride `stride`. Values above the diagonal are overwritten and
// have no meaning.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"

namespace vesta {

// Kernels also access rows beyond the last one (padding), so every stride must be at least PaddedRows(rows).
constexpr Index kFrontPad = 8;
constexpr Index PaddedRows(Index rows) { return (rows + kFrontPad - 1) / kFrontPad * kFrontPad + kFrontPad; }

// Kernels process up to kFrontStrip columns at a time. They therefore access values up to this many rows above the
// diagonal, rounded up to a multiple of kFrontPad.
constexpr Index kFrontStrip = 6;

struct FrontPanel {
  double* values;
  Index stride, rows, pivots;
};

struct FrontKernels {
  // Replaces the panel by the columns of the Cholesky factor. least: one value >= 0 per pivot. If the pivot is not
  // larger, it is replaced by this value, or by 1 if the value is 0. Returns the number of replaced pivots.
  Index (*factorize)(const FrontPanel& panel, const double* least);
  // update -= L2 L2^T, in the columns [begin, end) of the lower triangle. L2 is the factorised panel below its pivots.
  void (*subtract_outer)(const FrontPanel& panel, double* update, Index update_stride, Index begin, Index end);
  // update = -L2 L2^T, without reading `update`; the same bits as after zeroing it.
  void (*negative_outer)(const FrontPanel& panel, double* update, Index update_stride, Index begin, Index end);
  // Forward substitution (L y = x) for this front: replaces x[0..pivots) by y and subtracts L2 y from x[pivots..rows).
  void (*forward)(const FrontPanel& panel, double* x);
  // Back substitution (L^T y = x) for this front: replaces x[0..pivots) by y. x[pivots..rows) already contains the
  // solution of the rows below.
  void (*backward)(const FrontPanel& panel, double* x);
};

// The kernels for an instruction set that the CPU supports.
const FrontKernels& FrontKernelsFor(Isa isa);

}  // namespace vesta
