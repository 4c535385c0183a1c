// SPDX-License-Identifier: Apache-2.0
// The photometric loss of one view on a GPU: the operators of PhotometricLoss, in float.
#pragma once

#include "kernels/core/device_buffer.h"
#include "kernels/image/image_shape.h"
#include "kernels/image/metrics.h"
#include "kernels/image/photometric_loss.h"
#include "kernels/image/pixel_penalty.h"

namespace vesta {

// See PhotometricLinearization.
struct DevicePhotometricLinearization {
  ImageShape shape;
  DeviceBuffer<float> diagonal, curvature;
};

// GPU version of PhotometricLoss. Functions that return a value wait for the device.
class DevicePhotometricLoss {
 public:
  using VectorView = Span<float, Device>;
  using ConstVectorView = Span<const float, Device>;
  using Linearization = DevicePhotometricLinearization;

  // Bytes of one object for images of this many pixels. Gradients need three images of slopes, and products with W need
  // one more image.
  static double GradientBytes(SsimLinearization structure, double pixels) {
    return structure == SsimLinearization::kRootCenter ? 0 : 3 * ImageShape::kChannels * sizeof(float) * pixels;
  }
  static double ProductBytes(SsimLinearization structure, double pixels) {
    return GradientBytes(structure, pixels) * 4 / 3;
  }

  // Throws Error if CheckWeights does.
  explicit DevicePhotometricLoss(const PhotometricWeights& weights = {});

  const PhotometricWeights& weights() const { return weights_; }

  PhotometricValue Evaluate(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape);
  // gradient = d cost / d rendered (an approximation for kRootCenter, see loss_options.h). Value() can be called
  // afterwards.
  void Gradient(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape, VectorView gradient);
  void Linearize(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape, VectorView gradient,
                 Linearization& linearization);
  // Value of the last Gradient or Linearize. Waits for the device.
  PhotometricValue Value();
  // out = W v.
  void ApplyW(const Linearization& linearization, ConstVectorView v, VectorView out);

 private:
  // If gradient is null, computes only the sums. If linearization is null, does not compute W.
  void Run(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape, float* gradient,
           Linearization* linearization);
  void RunCenter(ConstVectorView rendered, ConstVectorView truth, const ImageShape& shape, float* gradient,
                 Linearization* linearization);

  PhotometricWeights weights_;
  PenaltyCoefficients<float> penalty_;
  DeviceBuffer<float> p_, q_, s_;  // slopes of 1 - SSIM
  DeviceBuffer<float> blurred_;    // result of the first step of a product with W
  DeviceBuffer<double> partial_sums_, sums_;
};

// GPU version of ImageQualityMeter (metrics.h). Measure quantises both images in place and waits.
class DeviceImageQualityMeter {
 public:
  static double Bytes(double /*pixels*/) { return 0; }
  ImageQuality Measure(Span<float, Device> rendered, Span<float, Device> truth, const ImageShape& shape);

 private:
  // The penalty of a pixel is half the squared error.
  DevicePhotometricLoss loss_{{.pixel = PixelLinearization::kL2}};
};

}  // namespace vesta
