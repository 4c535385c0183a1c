// SPDX-License-Identifier: Apache-2.0
#include "kernels/image/metrics.h"

#include <cmath>

#include "kernels/core/check.h"

namespace vesta {

ImageQuality ImageQualityOf(double squared, double dissimilarity, const ImageShape& shape) {
  const auto count = static_cast<double>(shape.NumValues());
  return {.psnr = -10.0 * std::log10(squared / count), .ssim = 1.0 - dissimilarity / count};
}

ImageQuality QualityOfMaskedImage(const ImageQuality& whole, double part) {
  return {.psnr = whole.psnr + 10.0 * std::log10(part), .ssim = 1.0 - (1.0 - whole.ssim) / part};
}

ImageQuality ImageQualityMeter::Measure(HostSpan<const float> rendered, HostSpan<const float> truth,
                                        const ImageShape& shape) {
  const Index n = shape.NumValues();
  VESTA_CHECK(rendered.size() == n && truth.size() == n, "rendered {}, truth {} values, want {}", rendered.size(),
              truth.size(), n);
  if (rendered_.size() != n) rendered_.Resize(n);
  if (truth_.size() != n) truth_.Resize(n);
  constexpr Index kGrain = 1 << 15;
  const double squared = ParallelSum<double>(n, kGrain, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index i = begin; i < end; ++i) {
      rendered_[i] = QuantizeTo8Bit(rendered[i]);
      truth_[i] = QuantizeTo8Bit(truth[i]);
      const double error = static_cast<double>(rendered_[i]) - static_cast<double>(truth_[i]);
      sum += error * error;
    }
    return sum;
  });
  return ImageQualityOf(squared, loss_.Evaluate(rendered_, truth_, shape).dissimilarity, shape);
}

}  // namespace vesta
