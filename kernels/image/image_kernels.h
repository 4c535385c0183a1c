// Loops over image rows, compiled once per instruction set. Plain pointers: this is the seam between *.simd.cpp and the
// classes that own memory and threads (photometric_loss.h, ssim_jacobian.h), which are what others use.
//
// Images here have planes of height * width values, one after the other (image_shape.h). Each function handles rows
// begin..end of one plane, writes only those rows of its outputs, and gives them the same bits however the rows are
// divided into ranges. G is the window given by the taps of one axis, zero padded. Outputs must not overlap inputs.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"

namespace vesta {

// Rows to work on, and scratch memory for them.
template <class S>
struct RowRange {
  int width, height, plane;
  int begin, end;
  const S* taps;  // kWindowTaps weights, symmetric
  S* scratch;     // kScratchRows rows of ScratchStride(width) values, aligned to 64 bytes, holding anything

  static constexpr int kScratchRows = 176;
};

// Values from one scratch row to the next: the row's, rounded up to 64; 16 values of padding before and behind them;
// and an odd number of cache lines in all, so that rows below each other do not compete for the same few lines of the
// cache.
constexpr Index ScratchStride(int width) { return 16 * ((4 * ((Index{width} + 63) / 64) + 2) | 1); }

// Values of both losses; on request 1 - SSIM of each window and the slopes p, q, s of 1 - SSIM
// (photometric_formula.h).
template <class S>
struct WindowArgs {
  const S *rendered, *truth;
  S floor;                                     // of the absolute value, > 0
  double* row_sums;                            // three for each row of each plane: sums of |e|, floored |e|, 1 - SSIM
  S* dissimilarity = nullptr;                  // null: not wanted
  S *p = nullptr, *q = nullptr, *s = nullptr;  // all null: not wanted
};

// gradient = ssim * J^T 1 + l1 * slope of the floored absolute value, J the Jacobian of 1 - SSIM;
// diagonal = ssim * G s + l1 * its curvature; curvature = the window curvature (photometric_formula.h).
template <class S>
struct GradientArgs {
  const S *rendered, *truth;
  S l1, ssim, floor;
  double* row_sums;  // as in WindowArgs
  S* gradient;
  S *diagonal, *curvature;  // both null: not wanted
};

// Jacobian of 1 - SSIM or its transpose: out = J in, or J^T in.
template <class S>
struct JacobianArgs {
  const S *rendered, *truth;
  const S *p, *q, *s;
  const S* in;
  S* out;
};

// out = d o v + scale * G (c o (G v)).
template <class S>
struct CurvatureArgs {
  const S *v, *c, *d;
  S scale;
  S* out;
};

// out = scale * G in + d.
template <class S>
struct BlurAddArgs {
  const S *in, *d;
  S scale;
  S* out;
};

template <class S>
struct ImageKernels {
  void (*windows)(const RowRange<S>&, const WindowArgs<S>&);
  void (*gradient)(const RowRange<S>&, const GradientArgs<S>&);
  void (*tangent)(const RowRange<S>&, const JacobianArgs<S>&);
  void (*adjoint)(const RowRange<S>&, const JacobianArgs<S>&);
  void (*curvature)(const RowRange<S>&, const CurvatureArgs<S>&);
  void (*blur_add)(const RowRange<S>&, const BlurAddArgs<S>&);
};

// The kernels compiled for one instruction set, which the CPU must have. S is float or double.
template <class S>
const ImageKernels<S>& ImageKernelsFor(Isa isa);

}  // namespace vesta
