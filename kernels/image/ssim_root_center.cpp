// Gauss-Newton on the root of 1 - SSIM, each score differentiated by its own pixel alone (3DGS-LM).
#include "kernels/core/parallel.h"
#include "kernels/image/photometric_linearization.h"

namespace vesta {
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
