// SPDX-License-Identifier: Apache-2.0
// PSNR and SSIM of images, as 8-bit files have them.
#pragma once

#include <algorithm>
#include <cmath>

#include "kernels/core/hd.h"
#include "kernels/image/photometric_loss.h"
#include "kernels/math/isa.h"

namespace vesta {

// Colours as an image file of 8 bits holds them.
inline namespace VESTA_ISA {

// x as an 8-bit value shows it: round(255 clamp(x, 0, 1)) / 255. Not a number stays not a number.
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

// Of quantised images, from their sums over pixels and channels: of squared errors, and of 1 - SSIM.
ImageQuality ImageQualityOf(double squared, double dissimilarity, const ImageShape& shape);

// The quality of an image of which only this part of the pixels, in (0, 1], counts, from that of the whole in which the
// others have no error of their own: the same sums over fewer pixels.
ImageQuality OfPart(const ImageQuality& whole, double part);

// Measures views one after the other; keeps its working memory. Truth and rendered image are both quantised first.
class ImageQualityMeter {
 public:
  // Of its images.
  static double Bytes(double pixels) { return 2 * ImageShape::kChannels * sizeof(float) * pixels; }
  // Sizes must be those of the shape, else throws Error.
  ImageQuality Measure(HostSpan<const float> rendered, HostSpan<const float> truth, const ImageShape& shape);

 private:
  PhotometricLoss<float> loss_;
  HostBuffer<float> rendered_, truth_;
};

}  // namespace vesta
