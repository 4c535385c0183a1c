// Image quality as reported: PSNR and SSIM of 8-bit images.
#pragma once

#include "kernels/image/photometric_loss.h"
#include "kernels/image/quantize.h"

namespace vesta {

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
