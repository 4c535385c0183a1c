// The exposure of a photograph: an affine map of each colour channel.
#pragma once

#include <array>

#include "kernels/core/span.h"

namespace vesta::gs {

// value of channel c -> gain[c] value + offset[c]. Colours as stored in the file, 0 to 1. None by default.
struct AffineColor {
  std::array<double, 3> gain{1, 1, 1}, offset{};

  bool operator==(const AffineColor&) const = default;
  bool is_none() const { return *this == AffineColor{}; }
  // What takes it back. No gain may be 0.
  AffineColor Inverse() const;
  // First that one, then this.
  AffineColor After(const AffineColor& first) const;

  // In place, on every pixel of a planar image.
  template <class S>
  void Apply(HostSpan<S> image) const;
};

}  // namespace vesta::gs
