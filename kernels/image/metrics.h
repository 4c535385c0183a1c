// Image quality as reported: PSNR and SSIM of 8-bit images.
#pragma once

#include "kernels/image/photometric_loss.h"

namespace vesta {

struct ImageQuality {
  double psnr = 0.0;  // 10 log10(1 / mean squared error) in dB, over all pixels and channels; infinite for equal images
  double ssim = 0.0;  // mean over pixels and channels, with the window of the loss (zero padded)
};

// x as an 8-bit value shows it: round(255 clamp(x, 0, 1)) / 255. Not a number stays not a number.
float QuantizeTo8Bit(float x);

// Measures views one after the other; keeps its working memory. Truth and rendered image are both quantised first.
class ImageQualityMeter {
 public:
  // Sizes must be those of the shape, else throws Error.
  ImageQuality Measure(HostSpan<const float> rendered, HostSpan<const float> truth, const ImageShape& shape);

 private:
  PhotometricLoss<float> loss_;
  HostBuffer<float> rendered_, truth_;
};

}  // namespace vesta
