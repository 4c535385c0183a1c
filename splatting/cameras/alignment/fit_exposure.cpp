// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/alignment/fit_exposure.h"

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "solver/levenberg_marquardt.h"
#include "splatting/cameras/derivatives/view_linearization.h"

namespace vesta::gs {
namespace {

using DoubleBackend = CpuBackend<double>;

// ViewProblem with a camera that stands still: the image is rendered once.
class ExposureProblem final : public Problem<DoubleBackend>, public OnManifold<DoubleBackend> {
 public:
  ExposureProblem(HostSpan<const float> rendered, HostSpan<const float> truth, const ImageShape& shape,
                  const PhotometricWeights& weights, HostSpan<const std::uint8_t> mask)
      : rendered_(rendered), loss_(std::make_shared<PhotometricLoss<float>>(weights)) {
    target_.camera.width = shape.width, target_.camera.height = shape.height;
    target_.truth = truth, target_.mask = mask;
  }

  Index num_parameters() const override { return kViewParameters; }
  Index num_tangent() const override { return kFree.num_tangent(); }
  double Cost(ConstVectorView x) override {
    image_.CopyFrom(rendered_);
    Unpack(x).color.Apply(image_.view());
    return EvaluateLoss(*loss_, target_, image_.view()).cost;
  }
  std::unique_ptr<Linearization<DoubleBackend>> Linearize(ConstVectorView x) override {
    HostBuffer<float> rendered;
    rendered.CopyFrom(rendered_);
    return std::make_unique<ViewLinearization<float>>(kFree, Unpack(x).color, target_, std::move(rendered),
                                                      HostBuffer<float>(), loss_);
  }
  void Plus(DoubleBackend& /*backend*/, ConstVectorView x, ConstVectorView delta, VectorView out) override {
    Pack(gs::Plus(Unpack(x), kFree, delta), out);
  }

 private:
  static constexpr FreeUnknowns kFree{.pose = false, .color = true};

  HostSpan<const float> rendered_;
  TargetView<CpuBackend<float>> target_{};
  std::shared_ptr<PhotometricLoss<float>> loss_;
  HostBuffer<float> image_;
};

}  // namespace

AffineColor FitExposure(HostSpan<const float> rendered, HostSpan<const float> truth, const ImageShape& shape,
                        const PhotometricWeights& weights, HostSpan<const std::uint8_t> mask) {
  VESTA_CHECK(rendered.size() == shape.NumValues() && truth.size() == shape.NumValues(),
              "rendered {}, truth {} values, want {}", rendered.size(), truth.size(), shape.NumValues());
  ExposureProblem problem(rendered, truth, shape, weights, mask);
  HostBuffer<double> x(kViewParameters);
  Pack({}, x);
  SolveLm(problem, x);
  return Unpack(x).color;
}

}  // namespace vesta::gs
