#include "splatting/cameras/unknowns/affine_color.h"

#include "kernels/core/vector_backend.h"
#include "splatting/cameras/unknowns/exposed_colors.h"

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
  Expose<CpuBackend<S>>(*this, image);
}
template void AffineColor::Apply(HostSpan<float> image) const;
template void AffineColor::Apply(HostSpan<double> image) const;

}  // namespace vesta::gs
