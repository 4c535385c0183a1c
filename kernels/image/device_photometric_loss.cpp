#include "kernels/image/device_photometric_loss.h"

#include "kernels/core/check.h"
#include "kernels/image/device_image_passes.h"

namespace vesta {
namespace {

template <class T>
void ResizeIfNeeded(DeviceBuffer<T>& buffer, Index size) {
  if (buffer.size() != size) buffer.ResizeForOverwrite(size);
}

}  // namespace

DevicePhotometricLoss::DevicePhotometricLoss(const PhotometricWeights& weights)
    : weights_(weights), penalty_(PenaltyCoefficientsOf<float>(weights)) {
  VESTA_CHECK(weights.l1 >= 0.0 && weights.ssim >= 0.0 && weights.l1_floor >= 0.0, "weights {}, {}, floor {}",
              weights.l1, weights.ssim, weights.l1_floor);
  if (weights.structure != SsimLinearization::kQuadratic) {
    Fail("on a GPU SSIM is made a quadratic; take the CPU for its root");
  }
}

void DevicePhotometricLoss::Run(ConstView rendered, ConstView truth, const ImageShape& shape, float* gradient,
                                Linearization* linearization) {
  const Index n = shape.NumValues();
  VESTA_CHECK(rendered.size() == n && truth.size() == n, "rendered {}, truth {} values, want {}", rendered.size(),
              truth.size(), n);
  ResizeIfNeeded(partial_sums_, device_image::NumPartialSums(shape));
  ResizeIfNeeded(sums_, 3);
  WindowsOperator<float> windows{rendered.data(), truth.data(), penalty_, nullptr, nullptr, nullptr, nullptr};
  if (gradient != nullptr) {
    for (auto* slopes : {&p_, &q_, &s_}) ResizeIfNeeded(*slopes, n);
    windows.p = p_.data(), windows.q = q_.data(), windows.s = s_.data();
    if (linearization != nullptr) windows.curvature = linearization->curvature.data();
  }
  device_image::Windows(shape, windows, partial_sums_.data(), sums_.data());
  if (gradient == nullptr) return;
  device_image::Gradient(shape, {rendered.data(), truth.data(), p_.data(), q_.data(), s_.data(),
                                 static_cast<float>(weights_.l1), static_cast<float>(weights_.ssim), penalty_, gradient,
                                 linearization != nullptr ? linearization->diagonal.data() : nullptr});
}

PhotometricValue DevicePhotometricLoss::Value() {
  VESTA_CHECK(sums_.size() == 3, "no loss has been computed");
  double sums[3];
  sums_.CopyTo({sums, 3});
  PhotometricValue value;
  value.absolute = sums[0], value.pixelwise = sums[1], value.dissimilarity = sums[2];
  value.cost = weights_.l1 * value.pixelwise + weights_.ssim * value.dissimilarity;
  value.objective = weights_.l1 * value.absolute + weights_.ssim * value.dissimilarity;
  return value;
}

PhotometricValue DevicePhotometricLoss::Evaluate(ConstView rendered, ConstView truth, const ImageShape& shape) {
  Run(rendered, truth, shape, nullptr, nullptr);
  return Value();
}

void DevicePhotometricLoss::Gradient(ConstView rendered, ConstView truth, const ImageShape& shape, View gradient) {
  VESTA_CHECK(gradient.size() == shape.NumValues(), "gradient {} values, want {}", gradient.size(), shape.NumValues());
  Run(rendered, truth, shape, gradient.data(), nullptr);
}

void DevicePhotometricLoss::Linearize(ConstView rendered, ConstView truth, const ImageShape& shape, View gradient,
                                      Linearization& linearization) {
  VESTA_CHECK(gradient.size() == shape.NumValues(), "gradient {} values, want {}", gradient.size(), shape.NumValues());
  linearization.shape = shape;
  ResizeIfNeeded(linearization.diagonal, shape.NumValues());
  ResizeIfNeeded(linearization.curvature, shape.NumValues());
  Run(rendered, truth, shape, gradient.data(), &linearization);
}

void DevicePhotometricLoss::ApplyW(const Linearization& linearization, ConstView v, View out) {
  const ImageShape& shape = linearization.shape;
  const Index n = shape.NumValues();
  VESTA_CHECK(v.size() == n && out.size() == n, "v {}, out {} values, want {}", v.size(), out.size(), n);
  ResizeIfNeeded(blurred_, n);
  device_image::WeightedBlur(shape, {v.data(), linearization.curvature.data(), blurred_.data()});
  device_image::BlurAdd(
      shape, {blurred_.data(), static_cast<float>(weights_.ssim), linearization.diagonal.data(), v.data(), out.data()});
}

}  // namespace vesta
