#include "problems/gaussian_splatting/cameras/affine_color.h"

#include "kernels/core/parallel.h"
#include "kernels/image/image_shape.h"

namespace vesta::gs {

AffineColor AffineColor::Inverse() const {
  AffineColor inverse;
  for (std::size_t c = 0; c < gain.size(); ++c) {
    inverse.gain[c] = 1 / gain[c];
    inverse.offset[c] = -offset[c] / gain[c];
  }
  return inverse;
}

AffineColor AffineColor::After(const AffineColor& first) const {
  AffineColor both;
  for (std::size_t c = 0; c < gain.size(); ++c) {
    both.gain[c] = gain[c] * first.gain[c];
    both.offset[c] = gain[c] * first.offset[c] + offset[c];
  }
  return both;
}

template <class S>
void AffineColor::Apply(HostSpan<S> image) const {
  constexpr Index kGrain = 1 << 15;  // pixels
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

}  // namespace vesta::gs
