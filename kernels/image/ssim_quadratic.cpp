// 1 - SSIM as a reweighted quadratic (photometric_formula.h).
#include "kernels/image/photometric_linearization.h"

namespace vesta {
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

}  // namespace vesta
