// SPDX-License-Identifier: Apache-2.0
// PSNR and SSIM of images, quantised to 8 bits.
#pragma once

#include <algorithm>
#include <cmath>

#include "kernels/core/hd.h"
#include "kernels/image/photometric_loss.h"
#include "kernels/math/isa.h"

namespace vesta {

// Quantisation of colours to 8 bits.
inline namespace VESTA_ISA {

// Rounds x to an 8-bit value: round(255 clamp(x, 0, 1)) / 255. NaN stays NaN.
VESTA_HD inline float QuantizeTo8Bit(float x) {
  using std::clamp, std::floor;
  return floor(255.0f * clamp(x, 0.0f, 1.0f) + 0.5f) / 255.0f;
}

}  // namespace VESTA_ISA

// Image quality as reported: PSNR and SSIM of 8-bit images.
struct ImageQuality {
  double psnr = 0.0;  // 10 log10(1 / mean squared error) in dB, over all pixels and channels; infinite for equal images
  double ssim = 0.0;  // mean over pixels and channels, with the window of the loss (zero padded)
};

// Computes the quality from two sums over pixels and channels of quantised images: squared errors, and 1 - SSIM.
ImageQuality ImageQualityOf(double squared, double dissimilarity, const ImageShape& shape);

// Converts the quality of a whole image to the quality of its unmasked part. part: fraction of unmasked pixels, in (0,
// 1]. Requires equal rendered and true values at masked pixels. Keeps the sums of squared errors and of 1 - SSIM, but
// divides them by the number of unmasked pixels instead of all pixels.
ImageQuality QualityOfMaskedImage(const ImageQuality& whole, double part);

// Measures the quality of views from quantised copies of rendered image and truth. Keeps its memory for the next view.
class ImageQualityMeter {
 public:
  // Bytes of its two images.
  static double Bytes(double pixels) { return 2 * ImageShape::kChannels * sizeof(float) * pixels; }
  // Throws Error if the sizes do not match the shape.
  ImageQuality Measure(HostSpan<const float> rendered, HostSpan<const float> truth, const ImageShape& shape);

 private:
  PhotometricLoss<float> loss_;
  HostBuffer<float> rendered_, truth_;
};

}  // namespace vesta
