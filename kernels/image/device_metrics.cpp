// SPDX-License-Identifier: Apache-2.0
#include "kernels/image/device_metrics.h"

#include "kernels/image/device_image_passes.h"

namespace vesta {

ImageQuality DeviceImageQualityMeter::Measure(Span<float, Device> rendered, Span<float, Device> truth,
                                              const ImageShape& shape) {
  device_image::Quantize(rendered.size(), rendered.data());
  device_image::Quantize(truth.size(), truth.data());
  const PhotometricValue value = loss_.Evaluate(rendered, truth, shape);
  return ImageQualityOf(2 * value.pixelwise, value.dissimilarity, shape);
}

}  // namespace vesta
