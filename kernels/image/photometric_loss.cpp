// SPDX-License-Identifier: Apache-2.0
#include "kernels/image/photometric_loss.h"

#include "kernels/core/buffer.h"
#include "kernels/core/check.h"
#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/parallel.h"
#include "kernels/core/profile.h"
#include "kernels/image/image_kernels.h"

namespace vesta {

namespace {

// 1 - SSIM as a reweighted quadratic (photometric_formula.h).
template <class S>
class QuadraticSsim final : public SsimStrategy<S> {
 public:
  using Linearization = PhotometricLinearization<S>;

  void Gradient(RowBands<S>& bands, const LossTerms<S>& loss, S* gradient, Linearization* linearization) override {
    GradientArgs<S> args{.loss = loss, .gradient = gradient};
    if (linearization != nullptr) {
      linearization->curvature.ResizeForOverwrite(bands.shape().NumValues());
      args.diagonal = linearization->diagonal.data();
      args.curvature = linearization->curvature.data();
    }
    bands.Run(&ImageKernels<S>::gradient, args);
  }

  void ApplyW(RowBands<S>& bands, const LossTerms<S>& loss, const Linearization& linearization, const S* v,
              S* out) override {
    bands.Run(&ImageKernels<S>::curvature, CurvatureArgs<S>{.v = v,
                                                            .c = linearization.curvature.data(),
                                                            .d = linearization.diagonal.data(),
                                                            .scale = loss.ssim,
                                                            .out = out});
  }
};

// kRootCenter of 3DGS-LM (loss_options.h).
template <class S>
class RootCenterSsim final : public SsimStrategy<S> {
 public:
  using Linearization = PhotometricLinearization<S>;

  void Gradient(RowBands<S>& bands, const LossTerms<S>& loss, S* gradient, Linearization* linearization) override {
    bands.Run(&ImageKernels<S>::center,
              CenterArgs<S>{.loss = loss,
                            .gradient = gradient,
                            .diagonal = linearization != nullptr ? linearization->diagonal.data() : nullptr});
  }

  void ApplyW(RowBands<S>&, const LossTerms<S>&, const Linearization& linearization, const S* v, S* out) override {
    const S* const diagonal = linearization.diagonal.data();
    ParallelForChunks(linearization.diagonal.size(), kGrain, [=](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) out[i] = diagonal[i] * v[i];
    });
  }

 private:
  static constexpr Index kGrain = Index{1} << 16;
};

template <class S>
std::unique_ptr<SsimStrategy<S>> MakeSsimStrategy(SsimLinearization kind) {
  switch (kind) {
    case SsimLinearization::kRootCenter:
      return std::make_unique<RootCenterSsim<S>>();
    default:
      return std::make_unique<QuadraticSsim<S>>();
  }
}

}  // namespace

void PhotometricValue::SetCost(const PhotometricWeights& weights) {
  cost = weights.l1 * pixelwise + weights.ssim * dissimilarity;
  objective = weights.l1 * absolute + weights.ssim * dissimilarity;
}

void CheckWeights(const PhotometricWeights& weights) {
  VESTA_CHECK(weights.l1 >= 0.0 && weights.ssim >= 0.0 && weights.l1_floor >= 0.0,
              "loss weights {} and {} and the L1 floor {} must not be negative", weights.l1, weights.ssim,
              weights.l1_floor);
  VESTA_CHECK(weights.huber_threshold > 0.0, "the Huber threshold is {}; it must be positive", weights.huber_threshold);
}

template <class S>
PhotometricLoss<S>::PhotometricLoss(const PhotometricWeights& weights, Isa isa)
    : weights_(weights),
      penalty_(PenaltyCoefficientsOf<S>(weights)),
      ssim_(MakeSsimStrategy<S>(weights.structure)),
      bands_(isa) {
  CheckWeights(weights);
}

template <class S>
void PhotometricLoss<S>::Resize(const ImageShape& shape) {
  bands_.Resize(shape);
  row_sums_.ResizeForOverwrite(3 * ImageShape::kChannels * static_cast<Index>(shape.height));
}

template <class S>
LossTerms<S> PhotometricLoss<S>::Terms(const S* rendered, const S* truth) {
  return {.rendered = rendered,
          .truth = truth,
          .penalty = penalty_,
          .l1 = static_cast<S>(weights_.l1),
          .ssim = static_cast<S>(weights_.ssim),
          .row_sums = row_sums_.data()};
}

template <class S>
PhotometricValue PhotometricLoss<S>::Run(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape,
                                         S* gradient, Linearization* linearization) {
  const ScopedPhase phase("loss");
  const Index n = shape.NumValues();
  VESTA_CHECK(rendered.size() == n && truth.size() == n, "rendered {}, truth {} values, want {}", rendered.size(),
              truth.size(), n);
  Resize(shape);
  const LossTerms<S> loss = Terms(rendered.data(), truth.data());
  if (gradient == nullptr) {
    bands_.Run(&ImageKernels<S>::value, ValueArgs<S>{loss});
  } else {
    ssim_->Gradient(bands_, loss, gradient, linearization);
  }
  PhotometricValue& value = value_;
  value = {};
  for (Index i = 0; i < row_sums_.size(); i += 3) {
    value.absolute += row_sums_[i];
    value.pixelwise += row_sums_[i + 1];
    value.dissimilarity += row_sums_[i + 2];
  }
  value.SetCost(weights_);
  return value;
}

template <class S>
PhotometricValue PhotometricLoss<S>::Evaluate(ConstVectorView rendered, ConstVectorView truth,
                                              const ImageShape& shape) {
  return Run(rendered, truth, shape, nullptr, nullptr);
}

template <class S>
PhotometricValue PhotometricLoss<S>::Gradient(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape,
                                              VectorView gradient) {
  VESTA_CHECK(gradient.size() == shape.NumValues(), "gradient {} values, want {}", gradient.size(), shape.NumValues());
  return Run(rendered, truth, shape, gradient.data(), nullptr);
}

template <class S>
PhotometricValue PhotometricLoss<S>::Linearize(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape,
                                               VectorView gradient, Linearization& linearization) {
  VESTA_CHECK(gradient.size() == shape.NumValues(), "gradient {} values, want {}", gradient.size(), shape.NumValues());
  linearization.shape = shape;
  linearization.diagonal.ResizeForOverwrite(shape.NumValues());
  return Run(rendered, truth, shape, gradient.data(), &linearization);
}

template <class S>
void PhotometricLoss<S>::ApplyW(const Linearization& linearization, ConstVectorView v, VectorView out) {
  const ScopedPhase phase("loss");
  const ImageShape& shape = linearization.shape;
  const Index n = shape.NumValues();
  VESTA_CHECK(v.size() == n && out.size() == n, "v {}, out {} values, want {}", v.size(), out.size(), n);
  Resize(shape);
  ssim_->ApplyW(bands_, Terms(nullptr, nullptr), linearization, v.data(), out.data());
}

template class PhotometricLoss<float>;
template class PhotometricLoss<double>;

template <class S>
RowBands<S>::RowBands(Isa isa) : kernels_(ImageKernelsFor<S>(isa)) {
  const auto taps = GaussianTaps();
  for (std::size_t k = 0; k < taps.size(); ++k) taps_[k] = static_cast<S>(taps[k]);
}

template <class S>
void RowBands<S>::Resize(const ImageShape& shape) {
  VESTA_CHECK(shape.width >= 1 && shape.height >= 1, "an image of {} x {} pixels is empty", shape.width, shape.height);
  shape_ = shape;
  bands_ = (shape.height + kBandRows - 1) / kBandRows;
  const int rows = (shape.height + bands_ - 1) / bands_;
  band_rows_ = (rows + kBandUnit - 1) / kBandUnit * kBandUnit;
}

template <class S>
S* RowBands<S>::Scratch() const {
  thread_local HostBuffer<S> scratch;
  const Index size = RowRange<S>::kScratchRows * ScratchStride(shape_.width);
  if (scratch.size() < size) scratch.ResizeForOverwrite(size);
  return scratch.data();
}

template class RowBands<float>;
template class RowBands<double>;

VESTA_DECLARE_PER_ISA(template <class S> const ImageKernels<S>& CompiledImageKernels();)

template <class S>
const ImageKernels<S>& ImageKernelsFor(Isa isa) {
  return VESTA_OF_ISA(isa, CompiledImageKernels<S>)();
}

template const ImageKernels<float>& ImageKernelsFor<float>(Isa);
template const ImageKernels<double>& ImageKernelsFor<double>(Isa);

}  // namespace vesta
