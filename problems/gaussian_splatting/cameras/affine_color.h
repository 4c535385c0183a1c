// The exposure of a photograph: an affine map of each colour channel.
#pragma once

#include <array>

#include "kernels/core/span.h"
#include "kernels/image/image_shape.h"

namespace vesta::gs {

// value of channel c -> gain[c] value + offset[c]. Colours as stored in the file, 0 to 1. None by default.
struct AffineColor {
  std::array<double, 3> gain{1, 1, 1}, offset{};

  // In place, on every pixel of a planar image.
  template <class S>
  void Apply(HostSpan<S> image) const;
};

// The one that brings `rendered` closest to `truth` in the squared error of all their pixels, channel by channel; both
// planar and of that shape. A gain that nothing tells of, since the rendered channel is the same everywhere, is 1.
AffineColor FitAffineColor(HostSpan<const float> rendered, HostSpan<const float> truth, const ImageShape& shape);

}  // namespace vesta::gs
