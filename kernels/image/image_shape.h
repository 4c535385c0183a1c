// SPDX-License-Identifier: Apache-2.0
// Memory layout of images in kernels/image.
#pragma once

#include "kernels/core/span.h"

namespace vesta {

// Three planes (red, green, blue) of `height` rows of `width` values, without padding. The value of channel c at row i,
// column j is at (c * height + i) * width + j.
struct ImageShape {
  int width = 0;
  int height = 0;

  static constexpr int kChannels = 3;
  // Number of values in one plane; in all three planes.
  Index PlaneSize() const { return static_cast<Index>(width) * height; }
  Index NumValues() const { return kChannels * PlaneSize(); }
  bool operator==(const ImageShape&) const = default;
};

}  // namespace vesta
