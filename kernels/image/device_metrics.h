// Image quality as reported, of images in the memory of a GPU.
#pragma once

#include "kernels/image/device_photometric_loss.h"
#include "kernels/image/metrics.h"

namespace vesta {

// As ImageQualityMeter, but both images are quantised where they are. Waits for the device.
class DeviceImageQualityMeter {
 public:
  ImageQuality Measure(Span<float, Device> rendered, Span<float, Device> truth, const ImageShape& shape);

 private:
  // Its penalty of a pixel is half the square of the error.
  DevicePhotometricLoss loss_{{.pixel = PixelLinearization::kL2}};
};

}  // namespace vesta
