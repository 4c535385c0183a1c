#include "kernels/image/photometric_loss.h"

#include <algorithm>
#include <limits>

#include "kernels/core/check.h"

namespace vesta {
namespace {

template <class S>
void ResizeIfNeeded(HostBuffer<S>& buffer, Index size) {
  if (buffer.size() != size) buffer.Resize(size);
}

}  // namespace

template <class S>
PhotometricLoss<S>::PhotometricLoss(const PhotometricWeights& weights, Isa isa)
    : weights_(weights),
      // The smallest normal number stands for no floor: e / max(|e|, floor) is then sign(e), and 0 at 0.
      floor_(std::max(static_cast<S>(weights.l1_floor), std::numeric_limits<S>::min())),
      bands_(isa) {
  VESTA_CHECK(weights.l1 >= 0.0 && weights.ssim >= 0.0 && weights.l1_floor >= 0.0, "weights {}, {}, floor {}",
              weights.l1, weights.ssim, weights.l1_floor);
}

template <class S>
void PhotometricLoss<S>::Resize(const ImageShape& shape) {
  bands_.Resize(shape);
  ResizeIfNeeded(row_sums_, 3 * ImageShape::kChannels * static_cast<Index>(shape.height));
}

// gradient null: values alone; linearization null: no W.
template <class S>
PhotometricValue PhotometricLoss<S>::Run(ConstView rendered, ConstView truth, const ImageShape& shape, S* gradient,
                                         Linearization* linearization) {
  const Index n = shape.NumValues();
  VESTA_CHECK(rendered.size() == n && truth.size() == n, "rendered {}, truth {} values, want {}", rendered.size(),
              truth.size(), n);
  Resize(shape);
  if (gradient == nullptr) {
    bands_.Run(&ImageKernels<S>::windows,
               WindowArgs<S>{
                   .rendered = rendered.data(), .truth = truth.data(), .floor = floor_, .row_sums = row_sums_.data()});
  } else {
    bands_.Run(&ImageKernels<S>::gradient,
               GradientArgs<S>{.rendered = rendered.data(),
                               .truth = truth.data(),
                               .l1 = static_cast<S>(weights_.l1),
                               .ssim = static_cast<S>(weights_.ssim),
                               .floor = floor_,
                               .row_sums = row_sums_.data(),
                               .gradient = gradient,
                               .diagonal = linearization != nullptr ? linearization->diagonal.data() : nullptr,
                               .curvature = linearization != nullptr ? linearization->curvature.data() : nullptr});
  }
  PhotometricValue value;
  for (Index i = 0; i < row_sums_.size(); i += 3) {
    value.absolute += row_sums_[i];
    value.floored += row_sums_[i + 1];
    value.dissimilarity += row_sums_[i + 2];
  }
  value.cost = weights_.l1 * value.floored + weights_.ssim * value.dissimilarity;
  value.objective = weights_.l1 * value.absolute + weights_.ssim * value.dissimilarity;
  return value;
}

template <class S>
PhotometricValue PhotometricLoss<S>::Evaluate(ConstView rendered, ConstView truth, const ImageShape& shape) {
  return Run(rendered, truth, shape, nullptr, nullptr);
}

template <class S>
PhotometricValue PhotometricLoss<S>::Gradient(ConstView rendered, ConstView truth, const ImageShape& shape,
                                              View gradient) {
  VESTA_CHECK(gradient.size() == shape.NumValues(), "gradient {} values, want {}", gradient.size(), shape.NumValues());
  return Run(rendered, truth, shape, gradient.data(), nullptr);
}

template <class S>
PhotometricValue PhotometricLoss<S>::Linearize(ConstView rendered, ConstView truth, const ImageShape& shape,
                                               View gradient, Linearization& linearization) {
  VESTA_CHECK(gradient.size() == shape.NumValues(), "gradient {} values, want {}", gradient.size(), shape.NumValues());
  linearization.shape = shape;
  ResizeIfNeeded(linearization.diagonal, shape.NumValues());
  ResizeIfNeeded(linearization.curvature, shape.NumValues());
  return Run(rendered, truth, shape, gradient.data(), &linearization);
}

template <class S>
void PhotometricLoss<S>::ApplyW(const Linearization& linearization, ConstView v, View out) {
  const ImageShape& shape = linearization.shape;
  const Index n = shape.NumValues();
  VESTA_CHECK(v.size() == n && out.size() == n, "v {}, out {} values, want {}", v.size(), out.size(), n);
  Resize(shape);
  bands_.Run(&ImageKernels<S>::curvature, CurvatureArgs<S>{.v = v.data(),
                                                           .c = linearization.curvature.data(),
                                                           .d = linearization.diagonal.data(),
                                                           .scale = static_cast<S>(weights_.ssim),
                                                           .out = out.data()});
}

template <class S>
void PhotometricLoss<S>::ExactDiagonal(const Linearization& linearization, View out) {
  const ImageShape& shape = linearization.shape;
  const Index n = shape.NumValues();
  VESTA_CHECK(out.size() == n, "out {} values, want {}", out.size(), n);
  Resize(shape);
  bands_.RunSquared(&ImageKernels<S>::blur_add, BlurAddArgs<S>{.in = linearization.curvature.data(),
                                                               .d = linearization.diagonal.data(),
                                                               .scale = static_cast<S>(weights_.ssim),
                                                               .out = out.data()});
}

template class PhotometricLoss<float>;
template class PhotometricLoss<double>;

}  // namespace vesta
