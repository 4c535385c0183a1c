// The photometric loss of one view in the memory of a GPU: the operators of PhotometricLoss, in float.
#pragma once

#include "kernels/core/device_buffer.h"
#include "kernels/image/image_shape.h"
#include "kernels/image/photometric_loss.h"
#include "kernels/image/pixel_penalty.h"

namespace vesta {

// As PhotometricLinearization of SsimLinearization::kQuadratic, the one that there is on a GPU.
struct DevicePhotometricLinearization {
  ImageShape shape;
  DeviceBuffer<float> diagonal, curvature;
};

// As PhotometricLoss; what gives a value waits for the device, the rest does not.
class DevicePhotometricLoss {
 public:
  using View = Span<float, Device>;
  using ConstView = Span<const float, Device>;
  using Linearization = DevicePhotometricLinearization;

  // Throws Error for another.
  explicit DevicePhotometricLoss(const PhotometricWeights& weights = {});

  const PhotometricWeights& weights() const { return weights_; }

  PhotometricValue Evaluate(ConstView rendered, ConstView truth, const ImageShape& shape);
  // gradient = d cost / d rendered. The value can be asked for afterwards.
  void Gradient(ConstView rendered, ConstView truth, const ImageShape& shape, View gradient);
  void Linearize(ConstView rendered, ConstView truth, const ImageShape& shape, View gradient,
                 Linearization& linearization);
  // Of the last Gradient or Linearize. Waits.
  PhotometricValue Value();
  // out = W v.
  void ApplyW(const Linearization& linearization, ConstView v, View out);

 private:
  void Run(ConstView rendered, ConstView truth, const ImageShape& shape, float* gradient, Linearization* linearization);

  PhotometricWeights weights_;
  PenaltyCoefficients<float> penalty_;
  DeviceBuffer<float> p_, q_, s_;  // slopes of 1 - SSIM
  DeviceBuffer<float> blurred_;
  DeviceBuffer<double> partial_sums_, sums_;
};

}  // namespace vesta
