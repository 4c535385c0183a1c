// SPDX-License-Identifier: Apache-2.0
// Image quality as reported, of images in the memory of a GPU.
#pragma once

#include "kernels/image/device_photometric_loss.h"
#include "kernels/image/metrics.h"

namespace vesta {

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
