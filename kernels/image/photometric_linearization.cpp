// SPDX-License-Identifier: Apache-2.0
#include "kernels/image/photometric_linearization.h"

#include "kernels/core/parallel.h"

namespace vesta {

// 1 - SSIM as a reweighted quadratic (photometric_formula.h).

namespace {

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

}  // namespace

template <class S>
std::unique_ptr<SsimStrategy<S>> MakeQuadraticSsim() {
  return std::make_unique<QuadraticSsim<S>>();
}
template std::unique_ptr<SsimStrategy<float>> MakeQuadraticSsim();
template std::unique_ptr<SsimStrategy<double>> MakeQuadraticSsim();

// Gauss-Newton on the root of 1 - SSIM, each score differentiated by its own pixel alone (3DGS-LM).

namespace {

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

}  // namespace

template <class S>
std::unique_ptr<SsimStrategy<S>> MakeRootCenterSsim() {
  return std::make_unique<RootCenterSsim<S>>();
}
template std::unique_ptr<SsimStrategy<float>> MakeRootCenterSsim();
template std::unique_ptr<SsimStrategy<double>> MakeRootCenterSsim();

}  // namespace vesta
