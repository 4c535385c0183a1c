// SPDX-License-Identifier: Apache-2.0
// The photometric loss of one view: absolute differences and structural similarity (SSIM) of the rendered image and the
// photograph (truth).
//
//   cost = sum over pixels and channels of  l1 |e| + ssim (1 - SSIM),   e = rendered - truth
//
// as in Kerbl et al. 2023 (3D Gaussian Splatting), but summed instead of averaged. l1 and ssim are weights. Least
// squares also needs
//   * the exact gradient with respect to the rendered image;
//   * a symmetric positive semidefinite curvature operator W. The default is a reweighted quadratic: |e| with the
//     weight 1 / max(|e|, l1_floor), and 1 - SSIM = (Ge)^2 / D1 + l Var(e) / D2 with D1, D2 and l constant
//     (photometric_formula.h). At the linearisation point e^T W e / 2 is then exactly the cost minus half of the L1
//     term (with l1_floor = 0).
// loss_options.h lists other costs and other curvatures.
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

// Runs an image kernel over all rows of all planes, in parallel. Not thread-safe.
template <class S>
class RowBands {
 public:
  explicit RowBands(Isa isa);

  const ImageShape& shape() const { return shape_; }
  // Throws Error if width or height is less than 1.
  void Resize(const ImageShape& shape);

  // Runs `kernel` on images of the current shape.
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
    ParallelForChunks(Index{ImageShape::kChannels} * bands_, 1, std::cref(band));  // by reference: no allocation
  }

 private:
  // kBandRows: approximate number of rows per task (a band). It is a multiple of kBandUnit, the rows that kernels
  // compute together, and much larger than ten, because two adjacent tasks both compute the ten rows around their
  // border.
  static constexpr int kBandRows = 96, kBandUnit = 4;

  // Scratch memory of the calling thread, for images of the current width.
  S* Scratch() const;

  const ImageKernels<S>& kernels_;
  std::array<S, kWindowTaps> taps_{};
  ImageShape shape_;
  int bands_ = 0, band_rows_ = 0;  // per plane
};

// The curvature operator W at one rendered image. The caller owns one operator for each view linearised at the same
// time. It stores one or two images of 3 * height * width values, depending on SsimLinearization (`o`: elementwise
// product; G: blur with the SSIM window):
//   kQuadratic   diagonal, curvature:  W v = diagonal o v + ssim * G (curvature o (G v));
//   kRootCenter  diagonal:             W v = diagonal o v.
template <class S>
struct PhotometricLinearization {
  ImageShape shape;
  // Gram matrices use this diagonal instead of W. It is never negative. With kRootCenter, it is the exact diagonal of
  // W. With kQuadratic, it is the pointwise part, l1 * penalty'' + 2 ssim G(l / D2); the omitted part is negative for
  // most windows.
  HostBuffer<S> diagonal;
  HostBuffer<S> curvature;  // 2 (1/D1 - l/D2)
};

// The operations that depend on SsimLinearization. The caller checks sizes.
template <class S>
class SsimStrategy {
 public:
  using Linearization = PhotometricLinearization<S>;
  virtual ~SsimStrategy() = default;

  // Computes the sums of the loss, its gradient, and its linearization if not null.
  virtual void Gradient(RowBands<S>& bands, const LossTerms<S>& loss, S* gradient, Linearization* linearization) = 0;
  // out = W v. Only the weights of `loss` are used.
  virtual void ApplyW(RowBands<S>& bands, const LossTerms<S>& loss, const Linearization& linearization, const S* v,
                      S* out) = 0;
};

// Sums over all pixels and channels of one view.
struct PhotometricValue {
  double absolute = 0.0;       // |e|
  double pixelwise = 0.0;      // the pixel penalty: |e| with its floor, Huber's function, or e^2 / 2
  double dissimilarity = 0.0;  // 1 - SSIM
  double cost = 0.0;           // l1 * pixelwise + ssim * dissimilarity; Gradient returns its gradient
  double objective = 0.0;      // l1 * absolute + ssim * dissimilarity

  // Sets cost and objective from the sums.
  void SetCost(const PhotometricWeights& weights);
};

// Throws Error if a weight is negative or a threshold is not positive.
void CheckWeights(const PhotometricWeights& weights);

// Computes the loss, its gradient and products with W. It needs little memory, because kernels process a few rows at a
// time (row_blur.h). Each call uses all threads; their number changes no bit. An object serves one call at a time.
//
// Images are planar (image_shape.h) and finite. For negative values, see photometric_formula.h. Throws Error if a size
// is wrong. Outputs must not overlap inputs.
template <class S>
class PhotometricLoss {
 public:
  using VectorView = HostSpan<S>;
  using ConstVectorView = HostSpan<const S>;
  using Linearization = PhotometricLinearization<S>;

  // Bytes of scratch memory of all threads together, for gradients and for products with W. Assumes that images are at
  // most twice as wide as high.
  static double GradientBytes(SsimLinearization /*structure*/, double pixels) {
    const auto width = static_cast<int>(std::sqrt(2 * pixels));
    return sizeof(S) * NumThreads() * static_cast<double>(RowRange<S>::kScratchRows * ScratchStride(width));
  }
  static double ProductBytes(SsimLinearization structure, double pixels) { return GradientBytes(structure, pixels); }

  // Throws Error if CheckWeights does.
  explicit PhotometricLoss(const PhotometricWeights& weights = {}, Isa isa = ActiveIsa());

  const PhotometricWeights& weights() const { return weights_; }

  PhotometricValue Evaluate(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape);
  // gradient = d cost / d rendered (an approximation for kRootCenter, see loss_options.h).
  PhotometricValue Gradient(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape,
                            VectorView gradient);
  // Does the same, and computes W at this image.
  PhotometricValue Linearize(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape,
                             VectorView gradient, Linearization& linearization);

  // Value of the last Evaluate, Gradient or Linearize.
  PhotometricValue Value() const { return value_; }

  // out = W v.
  void ApplyW(const Linearization& linearization, ConstVectorView v, VectorView out);

 private:
  void Resize(const ImageShape& shape);
  LossTerms<S> Terms(const S* rendered, const S* truth);
  // If gradient is null, computes only the sums. If linearization is null, does not compute W.
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
