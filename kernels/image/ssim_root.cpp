// Gauss-Newton on the root of 1 - SSIM, with the exact Jacobian of SSIM.
#include <algorithm>

#include "kernels/image/photometric_linearization.h"

namespace vesta {
namespace {

template <class S>
class RootSsim final : public SsimStrategy<S> {
 public:
  using Linearization = PhotometricLinearization<S>;

  void Gradient(RowBands<S>& bands, const LossTerms<S>& loss, S* gradient, Linearization* linearization) override {
    GradientArgs<S> args{.loss = loss, .gradient = gradient};
    if (linearization == nullptr) return bands.Run(&ImageKernels<S>::gradient, args);
    const Index n = bands.shape().NumValues();
    linearization->slopes.Resize(n);
    linearization->weight.ResizeForOverwrite(n);
    args.p = linearization->slopes.p.data();
    args.q = linearization->slopes.q.data();
    args.s = linearization->slopes.s.data();
    args.weight = linearization->weight.data();
    bands.Run(&ImageKernels<S>::gradient, args);
    linearization->rendered = {loss.rendered, n};
    linearization->truth = {loss.truth, n};
    bands.RunSquared(&ImageKernels<S>::root_diagonal,
                     Args(loss, *linearization, nullptr, linearization->diagonal.data()));
  }

  void ApplyW(RowBands<S>& bands, const LossTerms<S>& loss, const Linearization& linearization, const S* v,
              S* out) override {
    bands.Run(&ImageKernels<S>::root, Args(loss, linearization, v, out));
  }

  void ExactDiagonal(RowBands<S>&, const LossTerms<S>&, const Linearization& linearization, S* out) override {
    std::copy(linearization.diagonal.begin(), linearization.diagonal.end(), out);
  }

 private:
  static RootArgs<S> Args(LossTerms<S> loss, const Linearization& linearization, const S* v, S* out) {
    loss.rendered = linearization.rendered.data();
    loss.truth = linearization.truth.data();
    return {.loss = loss,
            .p = linearization.slopes.p.data(),
            .q = linearization.slopes.q.data(),
            .s = linearization.slopes.s.data(),
            .weight = linearization.weight.data(),
            .v = v,
            .out = out};
  }
};

}  // namespace

template <class S>
std::unique_ptr<SsimStrategy<S>> MakeRootSsim() {
  return std::make_unique<RootSsim<S>>();
}
template std::unique_ptr<SsimStrategy<float>> MakeRootSsim();
template std::unique_ptr<SsimStrategy<double>> MakeRootSsim();

}  // namespace vesta
