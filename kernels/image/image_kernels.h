// SPDX-License-Identifier: Apache-2.0
// Loops over image rows, compiled once per instruction set. Plain pointers: this is the seam between *.simd.cpp and the
// classes that own memory and threads (photometric_loss.h), which are what others use.
//
// Images here have planes of height * width values, one after the other (image_shape.h). Each function handles rows
// begin..end of one plane, writes only those rows of its outputs, and gives them the same bits however the rows are
// divided into ranges. G is the window given by the taps of one axis, zero padded. Outputs must not overlap inputs.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"
#include "kernels/image/pixel_penalty.h"

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

// What the loss is made of.
template <class S>
struct LossTerms {
  const S *rendered, *truth;
  PenaltyCoefficients<S> penalty;
  S l1, ssim;        // weights
  double* row_sums;  // three for each row of each plane: sums of |e|, the pixel's penalty, 1 - SSIM
};

// The sums alone.
template <class S>
struct ValueArgs {
  LossTerms<S> loss;
};

// Also the gradient, ssim * J^T 1 + l1 * derivative of the penalty, J the Jacobian of 1 - SSIM. What is null is not
// wanted.
template <class S>
struct GradientArgs {
  LossTerms<S> loss;
  S* gradient;
  // ssim * G s + l1 * curvature of the penalty, and the window curvature (photometric_formula.h).
  S *diagonal = nullptr, *curvature = nullptr;
};

// The same with each score differentiated by its own pixel: J its own diagonal. diagonal (null: not wanted) =
// ssim * J^2 * weight of the root + l1 * curvature of the penalty.
template <class S>
struct CenterArgs {
  LossTerms<S> loss;
  S *gradient, *diagonal;
};

// out = d o v + scale * G (c o (G v)).
template <class S>
struct CurvatureArgs {
  const S *v, *c, *d;
  S scale;
  S* out;
};

template <class S>
struct ImageKernels {
  void (*value)(const RowRange<S>&, const ValueArgs<S>&);
  void (*gradient)(const RowRange<S>&, const GradientArgs<S>&);
  void (*center)(const RowRange<S>&, const CenterArgs<S>&);
  void (*curvature)(const RowRange<S>&, const CurvatureArgs<S>&);
};

// The kernels compiled for one instruction set, which the CPU must have. S is float or double.
template <class S>
const ImageKernels<S>& ImageKernelsFor(Isa isa);

}  // namespace vesta
