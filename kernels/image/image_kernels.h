// Loops over image rows, compiled once per instruction set. Plain pointers: this is the seam between *.simd.cpp and the
// classes that own memory and threads (photometric_loss.h, ssim_jacobian.h), which are what others use.
//
// All images here are single planes of height * width values. Each function handles rows begin..end, writes only those
// rows of its outputs, and gives them the same bits however the rows are divided into ranges that begin at even rows. G
// is the window given by the taps of one axis, zero padded. Outputs must not overlap inputs.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"

namespace vesta {

// Rows to work on, and scratch memory for them.
template <class S>
struct RowRange {
  int width, height;
  int begin, end;
  const S* taps;  // kWindowTaps weights, with a zero before and behind
  // kScratchRows rows of scratch_stride values, zero from kScratchPad before each row's first value to kScratchPad
  // after the width rounded up to kScratchPad; the kernels keep those zeros.
  S* scratch;
  Index scratch_stride;

  static constexpr Index kScratchRows = 8;
  static constexpr Index kScratchPad = 16;
};

// Values of both losses; on request 1 - SSIM of each window, the slopes p, q, s of 1 - SSIM and its window
// curvature (photometric_formula.h).
template <class S>
struct WindowArgs {
  const S *rendered, *truth;
  S floor;                                     // of the absolute value, > 0
  double* row_sums;                            // three for each row: sums of |e|, floored |e|, 1 - SSIM
  S* dissimilarity = nullptr;                  // null: not wanted
  S *p = nullptr, *q = nullptr, *s = nullptr;  // all null: not wanted
  S* curvature = nullptr;                      // null: not wanted; needs p, q, s
};

// gradient = ssim * J^T 1 + l1 * slope of the floored absolute value, J the Jacobian of 1 - SSIM;
// diagonal (null: not wanted) = ssim * G s + l1 * its curvature.
template <class S>
struct GradientArgs {
  const S *rendered, *truth;
  const S *p, *q, *s;
  S l1, ssim, floor;
  S *gradient, *diagonal;
};

// Jacobian of 1 - SSIM or its transpose: out = J in, or J^T in.
template <class S>
struct JacobianArgs {
  const S *rendered, *truth;
  const S *p, *q, *s;
  const S* in;
  S* out;
};

// out = c o G in.
template <class S>
struct WeightedBlurArgs {
  const S *in, *c;
  S* out;
};

// out = scale * G in + d o v; v null: v = 1.
template <class S>
struct BlurAddArgs {
  const S* in;
  S scale;
  const S *d, *v;
  S* out;
};

template <class S>
struct ImageKernels {
  void (*windows)(const RowRange<S>&, const WindowArgs<S>&);
  void (*gradient)(const RowRange<S>&, const GradientArgs<S>&);
  void (*tangent)(const RowRange<S>&, const JacobianArgs<S>&);
  void (*adjoint)(const RowRange<S>&, const JacobianArgs<S>&);
  void (*weighted_blur)(const RowRange<S>&, const WeightedBlurArgs<S>&);
  void (*blur_add)(const RowRange<S>&, const BlurAddArgs<S>&);
};

// The kernels compiled for one instruction set, which the CPU must have. S is float or double.
template <class S>
const ImageKernels<S>& ImageKernelsFor(Isa isa);

}  // namespace vesta
