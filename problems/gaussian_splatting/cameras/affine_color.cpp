#include "problems/gaussian_splatting/cameras/affine_color.h"

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::gs {
namespace {

constexpr Index kGrain = 1 << 15;  // pixels

struct Moments {
  double x = 0, y = 0, xx = 0, xy = 0;

  Moments& operator+=(const Moments& other) {
    x += other.x, y += other.y, xx += other.xx, xy += other.xy;
    return *this;
  }
};

}  // namespace

template <class S>
void AffineColor::Apply(HostSpan<S> image) const {
  const Index plane = image.size() / ImageShape::kChannels;
  for (int c = 0; c < ImageShape::kChannels; ++c) {
    const auto channel = static_cast<std::size_t>(c);
    const S factor = static_cast<S>(gain[channel]), shift = static_cast<S>(offset[channel]);
    S* values = image.data() + c * plane;
    ParallelFor(plane, kGrain, [&](Index i) { values[i] = factor * values[i] + shift; });
  }
}
template void AffineColor::Apply(HostSpan<float> image) const;
template void AffineColor::Apply(HostSpan<double> image) const;

AffineColor FitAffineColor(HostSpan<const float> rendered, HostSpan<const float> truth, const ImageShape& shape) {
  const Index n = shape.PlaneSize();
  VESTA_CHECK(rendered.size() == shape.NumValues() && truth.size() == shape.NumValues(),
              "rendered {}, truth {} values, want {}", rendered.size(), truth.size(), shape.NumValues());
  AffineColor color;
  for (int c = 0; c < ImageShape::kChannels; ++c) {
    const float *from = rendered.data() + c * n, *to = truth.data() + c * n;
    const Moments sums = ParallelSum<Moments>(n, kGrain, [&](Index begin, Index end) {
      Moments part;
      for (Index i = begin; i < end; ++i) {
        const double x = static_cast<double>(from[i]), y = static_cast<double>(to[i]);
        part += {x, y, x * x, x * y};
      }
      return part;
    });
    const double count = static_cast<double>(n), mean_x = sums.x / count, mean_y = sums.y / count;
    const double variance = sums.xx / count - mean_x * mean_x, covariance = sums.xy / count - mean_x * mean_y;
    const auto channel = static_cast<std::size_t>(c);
    // Under this the differences of the sums are rounding.
    if (variance > 1e-12) color.gain[channel] = covariance / variance;
    color.offset[channel] = mean_y - color.gain[channel] * mean_x;
  }
  return color;
}

}  // namespace vesta::gs
