// SPDX-License-Identifier: Apache-2.0
#include "kernels/image/device_photometric_loss.h"

#include "kernels/core/check.h"
#include "kernels/core/cuda_backend.h"
#include "kernels/core/profile.h"
#include "kernels/image/blur_blocks.h"

namespace vesta {
namespace {

template <class T>
void ResizeIfNeeded(DeviceBuffer<T>& buffer, Index size) {
  if (buffer.size() != size) buffer.ResizeForOverwrite(size);
}

}  // namespace

DevicePhotometricLoss::DevicePhotometricLoss(const PhotometricWeights& weights)
    : weights_(weights), penalty_(PenaltyCoefficientsOf<float>(weights)) {
  CheckWeights(weights);
}

void DevicePhotometricLoss::Run(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape,
                                float* gradient, Linearization* linearization) {
  const ScopedPhase phase("loss");
  const Index n = shape.NumValues();
  VESTA_CHECK(rendered.size() == n && truth.size() == n, "rendered {}, truth {} values, want {}", rendered.size(),
              truth.size(), n);
  ResizeIfNeeded(partial_sums_, device_image::NumPartialSums(shape));
  ResizeIfNeeded(sums_, 3);
  if (gradient != nullptr && weights_.structure == SsimLinearization::kRootCenter) {
    return RunCenter(rendered, truth, shape, gradient, linearization);
  }
  LossSumsOperator<float> loss_sums{rendered.data(), truth.data(), penalty_, nullptr, nullptr, nullptr, nullptr};
  float* diagonal = nullptr;
  if (gradient != nullptr) {
    for (auto* slopes : {&p_, &q_, &s_}) ResizeIfNeeded(*slopes, n);
    loss_sums.p = p_.data(), loss_sums.q = q_.data(), loss_sums.s = s_.data();
  }
  if (linearization != nullptr) {
    ResizeIfNeeded(linearization->curvature, n);
    loss_sums.curvature = linearization->curvature.data();
    diagonal = linearization->diagonal.data();
  }
  device_image::LossSums(shape, loss_sums, partial_sums_.data(), sums_.data());
  if (gradient == nullptr) return;
  const auto l1 = static_cast<float>(weights_.l1), ssim = static_cast<float>(weights_.ssim);
  device_image::Gradient(
      shape, {rendered.data(), truth.data(), p_.data(), q_.data(), s_.data(), l1, ssim, penalty_, gradient, diagonal});
}

void DevicePhotometricLoss::RunCenter(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape,
                                      float* gradient, Linearization* linearization) {
  const float tap = MakeWindowTaps<float>().tap[kWindowRadius];
  device_image::Center(
      shape,
      {rendered.data(), truth.data(), static_cast<float>(weights_.l1), static_cast<float>(weights_.ssim), penalty_,
       tap * tap, gradient, linearization != nullptr ? linearization->diagonal.data() : nullptr},
      partial_sums_.data(), sums_.data());
}

PhotometricValue DevicePhotometricLoss::Value() {
  VESTA_CHECK(sums_.size() == 3, "no loss has been computed");
  double sums[3];
  sums_.CopyTo({sums, 3});
  PhotometricValue value;
  value.absolute = sums[0], value.pixelwise = sums[1], value.dissimilarity = sums[2];
  value.SetCost(weights_);
  return value;
}

PhotometricValue DevicePhotometricLoss::Evaluate(ConstVectorView rendered, ConstVectorView truth,
                                                 const ImageShape& shape) {
  Run(rendered, truth, shape, nullptr, nullptr);
  return Value();
}

void DevicePhotometricLoss::Gradient(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape,
                                     VectorView gradient) {
  VESTA_CHECK(gradient.size() == shape.NumValues(), "gradient {} values, want {}", gradient.size(), shape.NumValues());
  Run(rendered, truth, shape, gradient.data(), nullptr);
}

void DevicePhotometricLoss::Linearize(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape,
                                      VectorView gradient, Linearization& linearization) {
  VESTA_CHECK(gradient.size() == shape.NumValues(), "gradient {} values, want {}", gradient.size(), shape.NumValues());
  linearization.shape = shape;
  ResizeIfNeeded(linearization.diagonal, shape.NumValues());
  Run(rendered, truth, shape, gradient.data(), &linearization);
}

void DevicePhotometricLoss::ApplyW(const Linearization& linearization, ConstVectorView v, VectorView out) {
  const ScopedPhase phase("loss");
  const ImageShape& shape = linearization.shape;
  const Index n = shape.NumValues();
  VESTA_CHECK(v.size() == n && out.size() == n, "v {}, out {} values, want {}", v.size(), out.size(), n);
  if (weights_.structure == SsimLinearization::kRootCenter) {
    return CudaBackend<float>().Multiply(linearization.diagonal, v, out);
  }
  ResizeIfNeeded(blurred_, n);
  device_image::WeightedBlur(shape, {v.data(), linearization.curvature.data(), blurred_.data()});
  device_image::BlurAdd(
      shape, {blurred_.data(), static_cast<float>(weights_.ssim), linearization.diagonal.data(), v.data(), out.data()});
}

ImageQuality DeviceImageQualityMeter::Measure(Span<float, Device> rendered, Span<float, Device> truth,
                                              const ImageShape& shape) {
  device_image::Quantize(rendered.size(), rendered.data());
  device_image::Quantize(truth.size(), truth.data());
  const PhotometricValue value = loss_.Evaluate(rendered, truth, shape);
  return ImageQualityOf(2 * value.pixelwise, value.dissimilarity, shape);
}

}  // namespace vesta
