#include "kernels/image/metrics.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"

namespace vesta {

float QuantizeTo8Bit(float x) { return std::floor(255.0f * std::clamp(x, 0.0f, 1.0f) + 0.5f) / 255.0f; }

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
  const auto count = static_cast<double>(n);
  const PhotometricValue value = loss_.Evaluate(rendered_, truth_, shape);
  return {.psnr = -10.0 * std::log10(squared / count), .ssim = 1.0 - value.dissimilarity / count};
}

}  // namespace vesta
