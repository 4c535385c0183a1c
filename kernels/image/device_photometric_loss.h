// SPDX-License-Identifier: Apache-2.0
// The photometric loss of one view in the memory of a GPU: the operators of PhotometricLoss, in float.
#pragma once

#include "kernels/core/device_buffer.h"
#include "kernels/image/image_shape.h"
#include "kernels/image/metrics.h"
#include "kernels/image/photometric_loss.h"
#include "kernels/image/pixel_penalty.h"

namespace vesta {

// As PhotometricLinearization.
struct DevicePhotometricLinearization {
  ImageShape shape;
  DeviceBuffer<float> diagonal, curvature;
};

// Like PhotometricLoss. Functions that return a value wait for the device, the others do not.
class DevicePhotometricLoss {
 public:
  using VectorView = Span<float, Device>;
  using ConstVectorView = Span<const float, Device>;
  using Linearization = DevicePhotometricLinearization;

  // As PhotometricLoss's, of one object: three slopes, and what W blurs.
  static double GradientBytes(SsimLinearization structure, double pixels) {
    return structure == SsimLinearization::kRootCenter ? 0 : 3 * ImageShape::kChannels * sizeof(float) * pixels;
  }
  static double ProductBytes(SsimLinearization structure, double pixels) {
    return GradientBytes(structure, pixels) * 4 / 3;
  }

  // Throws Error for negative weights or a Huber threshold that is not positive.
  explicit DevicePhotometricLoss(const PhotometricWeights& weights = {});

  const PhotometricWeights& weights() const { return weights_; }

  PhotometricValue Evaluate(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape);
  // gradient = d cost / d rendered (for kRootCenter an approximation: loss_options.h). The value is available
  // afterwards.
  void Gradient(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape, VectorView gradient);
  void Linearize(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape, VectorView gradient,
                 Linearization& linearization);
  // Of the last Gradient or Linearize. Waits.
  PhotometricValue Value();
  // out = W v.
  void ApplyW(const Linearization& linearization, ConstVectorView v, VectorView out);

 private:
  // gradient null: values alone; linearization null: no W.
  void Run(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape, float* gradient,
           Linearization* linearization);
  void RunCenter(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape, float* gradient,
                 Linearization* linearization);

  PhotometricWeights weights_;
  PenaltyCoefficients<float> penalty_;
  DeviceBuffer<float> p_, q_, s_;  // slopes of 1 - SSIM
  DeviceBuffer<float> blurred_;    // between the halves of W
  DeviceBuffer<double> partial_sums_, sums_;
};

// Image quality as reported.
//
// Like ImageQualityMeter, but quantises both images in place. Waits for the device.
class DeviceImageQualityMeter {
 public:
  static double Bytes(double /*pixels*/) { return 0; }
  ImageQuality Measure(Span<float, Device> rendered, Span<float, Device> truth, const ImageShape& shape);

 private:
  // The penalty of a pixel is half the squared error.
  DevicePhotometricLoss loss_{{.pixel = PixelLinearization::kL2}};
};

}  // namespace vesta
