// SPDX-License-Identifier: Apache-2.0
// The photometric loss of one view: absolute differences and structural similarity of a rendered image and the truth.
//
//   cost = sum over pixels and channels of  l1 |e| + ssim (1 - SSIM),   e = rendered - truth
// as in Kerbl et al. 2023 (3D Gaussian Splatting), but a sum, not a mean. What least squares needs from it:
//   * the exact gradient by the rendered image;
//   * a curvature operator W, symmetric positive semidefinite, that makes the loss a quadratic. By default it is a
//     reweighted one: |e| by the weight 1 / max(|e|, l1_floor), SSIM by 1 - SSIM = (Ge)^2 / D1 + l Var(e) / D2 with D1,
//     D2 and l frozen (photometric_formula.h). At the point of linearisation e^T W e / 2 is then exactly the cost, less
//     half of the L1 term (with l1_floor = 0).
// Other costs in place of |e| and other curvatures: loss_options.h.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>

#include "kernels/core/buffer.h"
#include "kernels/core/parallel.h"
#include "kernels/image/gaussian_window.h"
#include "kernels/image/image_kernels.h"
#include "kernels/image/image_shape.h"
#include "kernels/image/loss_options.h"

namespace vesta {

// Runs an image kernel over all rows of all planes, in parallel.
// S is float or double. One user at a time.
template <class S>
class RowBands {
 public:
  explicit RowBands(Isa isa);

  const ImageShape& shape() const { return shape_; }
  // Throws Error unless width and height are at least 1.
  void Resize(const ImageShape& shape);

  // Runs `kernel`, one of the members of ImageKernels, on images of the current shape.
  template <class Args>
  void Run(void (*ImageKernels<S>::*kernel)(const RowRange<S>&, const Args&), const Args& args) {
    const auto band = [&](Index task, Index) {
      const int plane = static_cast<int>(task) / bands_, first = static_cast<int>(task) % bands_ * band_rows_;
      const RowRange<S> rows{.width = shape_.width,
                             .height = shape_.height,
                             .plane = plane,
                             .begin = first,
                             .end = std::min(first + band_rows_, shape_.height),
                             .taps = taps_.data(),
                             .scratch = Scratch()};
      (kernels_.*kernel)(rows, args);
    };
    ParallelForChunks(Index{ImageShape::kChannels} * bands_, 1, std::cref(band));  // by reference: nothing is allocated
  }

 private:
  // About the number of rows in one task. Two tasks both compute the ten rows around their border, so a task has many
  // more rows than that, in a multiple of the rows that kernels compute at once.
  static constexpr int kBandRows = 96, kBandUnit = 4;

  // Scratch memory of the calling thread, for images of the current width.
  S* Scratch() const;

  const ImageKernels<S>& kernels_;
  std::array<S, kWindowTaps> taps_{};
  ImageShape shape_;
  int bands_ = 0, band_rows_ = 0;  // of one plane
};

// The curvature operator W of the photometric loss at one rendered image. Owned by the caller, one for each view that
// is linearised at the same time. Images of 3 * height * width values: the diagonal, and by the choice of
// SsimLinearization
//   kQuadratic   one more: W v = diagonal o v + ssim * G (curvature o (G v));
//   kRootCenter  none: W v = diagonal o v.
template <class S>
struct PhotometricLinearization {
  ImageShape shape;
  // The weight of Gram matrices in place of W: never negative. W's exact diagonal with the root; with the quadratic
  // l1 * penalty'' + 2 ssim G(l / D2), the pointwise part (the part left out is negative for most windows).
  HostBuffer<S> diagonal;
  HostBuffer<S> curvature;  // 2 (1/D1 - l/D2)
};

// One choice of SsimLinearization. Images are of the shape of `bands`; sizes are checked by the caller.
template <class S>
class SsimStrategy {
 public:
  using Linearization = PhotometricLinearization<S>;
  virtual ~SsimStrategy() = default;

  // Computes the sums of the loss, its gradient, and unless null its linearization.
  virtual void Gradient(RowBands<S>& bands, const LossTerms<S>& loss, S* gradient, Linearization* linearization) = 0;
  // out = W v. loss: its weights alone.
  virtual void ApplyW(RowBands<S>& bands, const LossTerms<S>& loss, const Linearization& linearization, const S* v,
                      S* out) = 0;
};

// Sums over all pixels and channels of one view.
struct PhotometricValue {
  double absolute = 0.0;       // |e|
  double pixelwise = 0.0;      // the cost in place of |e|: |e| with its floor, Huber's, or e^2 / 2
  double dissimilarity = 0.0;  // 1 - SSIM
  double cost = 0.0;           // l1 * pixelwise + ssim * dissimilarity: what Gradient is the gradient of
  double objective = 0.0;      // l1 * absolute + ssim * dissimilarity

  // Sets cost and objective from the sums.
  void Weigh(const PhotometricWeights& weights);
};

// Throws Error where a weight is negative, or a threshold is not positive.
void CheckWeights(const PhotometricWeights& weights);

// Holds the weights and next to no memory: the passes over the images keep what they need of a few rows in the cache
// (row_blur.h). Each call uses all threads and gives the same bits for any number of them. An object serves
// one call at a time. S is float or double. Images are planar (image_shape.h), finite and nowhere negative (negative
// values are harmless but see photometric_formula.h); views of a wrong size throw Error; outputs must not overlap
// inputs.
template <class S>
class PhotometricLoss {
 public:
  using VectorView = HostSpan<S>;
  using ConstVectorView = HostSpan<const S>;
  using Linearization = PhotometricLinearization<S>;

  // Bytes of what all objects together work in where they make a gradient, and with the products of W: scratch rows of
  // each thread (an image is taken to be up to twice as wide as high).
  static double GradientBytes(SsimLinearization /*structure*/, double pixels) {
    const auto width = static_cast<int>(std::sqrt(2 * pixels));
    return sizeof(S) * NumThreads() * static_cast<double>(RowRange<S>::kScratchRows * ScratchStride(width));
  }
  static double ProductBytes(SsimLinearization structure, double pixels) { return GradientBytes(structure, pixels); }

  // Throws Error for negative weights or a Huber threshold that is not positive.
  explicit PhotometricLoss(const PhotometricWeights& weights = {}, Isa isa = ActiveIsa());

  const PhotometricWeights& weights() const { return weights_; }

  PhotometricValue Evaluate(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape);
  // gradient = d cost / d rendered (for kRootCenter an approximation: loss_options.h).
  PhotometricValue Gradient(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape,
                            VectorView gradient);
  // The same, and W at this point.
  PhotometricValue Linearize(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape,
                             VectorView gradient, Linearization& linearization);

  // Of the last of these calls: asked for as of a loss on a device, where it waits.
  PhotometricValue Value() const { return value_; }

  // out = W v.
  void ApplyW(const Linearization& linearization, ConstVectorView v, VectorView out);

 private:
  void Resize(const ImageShape& shape);
  LossTerms<S> Terms(const S* rendered, const S* truth);
  // gradient null: values alone; linearization null: no W.
  PhotometricValue Run(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape, S* gradient,
                       Linearization* linearization);

  PhotometricWeights weights_;
  PenaltyCoefficients<S> penalty_;
  std::unique_ptr<SsimStrategy<S>> ssim_;
  RowBands<S> bands_;
  HostBuffer<double> row_sums_;
  PhotometricValue value_;
};

}  // namespace vesta
