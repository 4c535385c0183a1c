// SPDX-License-Identifier: Apache-2.0
// Loops over image rows, compiled once per instruction set. Only the classes of photometric_loss.h call them. These
// classes own the memory and use all threads.
//
// Images have planes of height * width values (image_shape.h). Each function processes rows begin..end of one plane and
// writes only these rows of its outputs. The division of the rows into ranges does not change any bit of the result.
// Outputs must not overlap inputs.
//
// G is the blur with the SSIM window, with zeros outside the image; `o` is the elementwise product. Other symbols:
// photometric_formula.h.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/span.h"
#include "kernels/image/pixel_penalty.h"

namespace vesta {

// A range of rows to process, and scratch memory. plane: 0, 1, 2 for red, green, blue. taps: weights of one axis of the
// window.
template <class S>
struct RowRange {
  int width, height, plane;
  int begin, end;
  const S* taps;  // kWindowTaps weights, symmetric
  S* scratch;     // kScratchRows rows of ScratchStride(width) values, aligned to 64 bytes, uninitialised

  static constexpr int kScratchRows = 176;
};

// Distance between two scratch rows, in values: the image width rounded up to a multiple of 64, and 16 values of
// padding on both sides. The distance is an odd number of cache lines, so that successive rows do not compete for the
// same cache sets.
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

// Also computes the gradient, ssim * J^T 1 + l1 * derivative of the penalty. J is the Jacobian of 1 - SSIM. Optional
// outputs may be null.
template <class S>
struct GradientArgs {
  LossTerms<S> loss;
  S* gradient;
  // diagonal = ssim * G s + l1 * curvature of the penalty; curvature: the window curvature.
  S *diagonal = nullptr, *curvature = nullptr;
};

// The same for kRootCenter (loss_options.h), with diagonal J. diagonal (may be null) = ssim * J^2 * SsimRootWeight + l1
// * curvature of the penalty.
template <class S>
struct CenterArgs {
  LossTerms<S> loss;
  S *gradient, *diagonal;
};

// out = d o v + scale * G (c o (G v)): a product with W of kQuadratic.
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
