// SPDX-License-Identifier: Apache-2.0
// Loops over image rows, compiled once per instruction set. They take plain pointers: this is the interface between
// *.simd.cpp and the classes that own memory and threads (photometric_loss.h). Other code uses those classes.
//
// Images have planes of height * width values, one after the other (image_shape.h). Each function processes rows
// begin..end of one plane and writes only these rows of its outputs. The result is bit-identical for any division of
// the rows into ranges. G is the blur with the window given by the taps of one axis, zero padded. Outputs must not
// overlap inputs.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"
#include "kernels/image/pixel_penalty.h"

namespace vesta {

// A range of rows to process, and scratch memory for it.
template <class S>
struct RowRange {
  int width, height, plane;
  int begin, end;
  const S* taps;  // kWindowTaps weights, symmetric
  S* scratch;     // kScratchRows rows of ScratchStride(width) values, aligned to 64 bytes, uninitialised

  static constexpr int kScratchRows = 176;
};

// Values from one scratch row to the next. A row has its width rounded up to 64 and 16 values of padding on both sides.
// The stride is an odd number of cache lines, so that rows below each other do not compete for the same cache sets.
constexpr Index ScratchStride(int width) { return 16 * ((4 * ((Index{width} + 63) / 64) + 2) | 1); }

// Inputs of the loss.
template <class S>
struct LossTerms {
  const S *rendered, *truth;
  PenaltyCoefficients<S> penalty;
  S l1, ssim;        // weights
  double* row_sums;  // three per row of each plane: sums of |e|, of the pixel penalty and of 1 - SSIM
};

// Computes only the sums.
template <class S>
struct ValueArgs {
  LossTerms<S> loss;
};

// Also computes the gradient, ssim * J^T 1 + l1 * derivative of the penalty, with J the Jacobian of 1 - SSIM. Optional
// outputs may be null.
template <class S>
struct GradientArgs {
  LossTerms<S> loss;
  S* gradient;
  // ssim * G s + l1 * curvature of the penalty, and the window curvature (photometric_formula.h).
  S *diagonal = nullptr, *curvature = nullptr;
};

// The same for kRootCenter, in which J is diagonal. diagonal (optional, may be null) = ssim * J^2 * weight of the root
// + l1 * curvature of the penalty.
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

// The kernels compiled for one instruction set, which the CPU must support. S is float or double.
template <class S>
const ImageKernels<S>& ImageKernelsFor(Isa isa);

}  // namespace vesta
