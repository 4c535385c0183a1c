// The photometric loss of one view: absolute differences and structural similarity of a rendered image and the truth.
//
//   cost = sum over pixels and channels of  l1 |e| + ssim (1 - SSIM),   e = rendered - truth
// as in Kerbl et al. 2023 (3D Gaussian Splatting), but a sum, not a mean. What least squares needs of it:
//   * the exact gradient by the rendered image;
//   * a curvature operator W, symmetric positive semidefinite, that makes the loss a reweighted quadratic: |e| by the
//     weight 1 / max(|e|, l1_floor), SSIM by 1 - SSIM = (Ge)^2 / D1 + l Var(e) / D2 with D1, D2 and l frozen
//     (photometric_formula.h). At the point of linearisation e^T W e / 2 is exactly the cost (with l1_floor = 0).
#pragma once

#include "kernels/core/buffer.h"
#include "kernels/image/row_bands.h"
#include "kernels/image/ssim_jacobian.h"

namespace vesta {

struct PhotometricWeights {
  double l1 = 0.8;
  double ssim = 0.2;
  // |e| below this is replaced by the parabola (e^2 / l1_floor + l1_floor) / 2, in the cost, the gradient and W alike.
  // 0 means |e| itself (with derivative 0 at e = 0). Colours are in 0..1.
  double l1_floor = 0.01;
};

// Sums over all pixels and channels of one view.
struct PhotometricValue {
  double absolute = 0.0;       // |e|
  double floored = 0.0;        // |e| with the floor
  double dissimilarity = 0.0;  // 1 - SSIM
  double cost = 0.0;           // l1 * floored + ssim * dissimilarity: what Gradient is the gradient of
  double objective = 0.0;      // l1 * absolute + ssim * dissimilarity: the loss without the floor
};

// W at one rendered image: W v = diagonal o v + ssim * G (curvature o (G v)). Owned by the caller, one for each view
// that is linearised at the same time. Two images of 3 * height * width values.
template <class S>
struct PhotometricLinearization {
  ImageShape shape;
  // l1 / max(|e|, l1_floor) + 2 ssim G(l / D2): the pointwise part of W. In place of W's exact diagonal it serves as
  // the weight of Gram matrices (the part left out is negative for most windows). Never negative.
  HostBuffer<S> diagonal;
  // 2 (1/D1 - l/D2).
  HostBuffer<S> curvature;
};

// Holds the weights and next to no memory: the passes over the images keep what they need of a few rows in the cache
// (row_blur.h). Each call uses all threads and gives the same bits for any number of them. An object serves
// one call at a time. S is float or double. Images are planar (image_shape.h), finite and nowhere negative (negative
// values are harmless but see photometric_formula.h); views of a wrong size throw Error; outputs must not overlap
// inputs.
template <class S>
class PhotometricLoss {
 public:
  using View = HostSpan<S>;
  using ConstView = HostSpan<const S>;
  using Linearization = PhotometricLinearization<S>;

  // Throws Error for negative weights.
  explicit PhotometricLoss(const PhotometricWeights& weights = {}, Isa isa = ActiveIsa());

  const PhotometricWeights& weights() const { return weights_; }

  PhotometricValue Evaluate(ConstView rendered, ConstView truth, const ImageShape& shape);
  // gradient = d cost / d rendered.
  PhotometricValue Gradient(ConstView rendered, ConstView truth, const ImageShape& shape, View gradient);
  // The same, and W at this point.
  PhotometricValue Linearize(ConstView rendered, ConstView truth, const ImageShape& shape, View gradient,
                             Linearization& linearization);

  // out = W v.
  void ApplyW(const Linearization& linearization, ConstView v, View out);
  // out = the exact diagonal of W. (The pointwise part is linearization.diagonal, at no cost.)
  void ExactDiagonal(const Linearization& linearization, View out);

 private:
  void Resize(const ImageShape& shape);
  PhotometricValue Run(ConstView rendered, ConstView truth, const ImageShape& shape, S* gradient,
                       Linearization* linearization);

  PhotometricWeights weights_;
  S floor_;
  RowBands<S> bands_;
  HostBuffer<double> row_sums_;
};

}  // namespace vesta
