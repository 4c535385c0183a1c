// The Jacobian of 1 - SSIM by the rendered image, as an operator.
#pragma once

#include "kernels/core/buffer.h"
#include "kernels/image/row_bands.h"

namespace vesta {

// The three slope images p, q, s of all windows, in which the derivative is exactly linear (photometric_formula.h):
//   d(1 - SSIM) = p o G(dx) + q o G(x o dx) + s o G((x - y) o dx).
template <class S>
struct SsimSlopeImages {
  HostBuffer<S> p, q, s;

  // Allocates when the size changes.
  void Resize(Index num_values);
};

// J at one rendered image x and truth y: 3 * height * width square, each row a window (centre pixel and channel).
// Keeps views of x and y, which must stay as they are; S is float or double. Memory: three images.
template <class S>
class SsimJacobian {
 public:
  using View = HostSpan<S>;
  using ConstView = HostSpan<const S>;

  explicit SsimJacobian(Isa isa = ActiveIsa()) : bands_(isa) {}

  // Also gives 1 - SSIM of each window. Sizes must be those of the shape, else throws Error.
  void Linearize(ConstView rendered, ConstView truth, const ImageShape& shape, View dissimilarity);
  // out = J v.
  void Apply(ConstView v, View out);
  // out = J^T u.
  void ApplyAdjoint(ConstView u, View out);
  // out_i = J_ii: the derivative of each window by its own centre ("centre-pixel SSIM").
  void Diagonal(View out) const;

 private:
  using Kernel = void (*ImageKernels<S>::*)(const RowRange<S>&, const JacobianArgs<S>&);
  void Run(Kernel kernel, ConstView in, View out);

  RowBands<S> bands_;
  SsimSlopeImages<S> slopes_;
  ConstView rendered_, truth_;
};

}  // namespace vesta
