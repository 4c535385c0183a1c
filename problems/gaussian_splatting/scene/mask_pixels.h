// SPDX-License-Identifier: Apache-2.0
// Per-pixel functors for masked pixels (masked_loss.h), for every memory space.
#pragma once

#include <cstdint>

#include "kernels/core/hd.h"
#include "kernels/core/span.h"

namespace vesta::gs {

// For pixel i of an image with three planes: if the mask excludes it, copies it from the other image.
template <class S>
struct ShowWhereLeftOut {
  const std::uint8_t* mask;
  const S* from;
  S* image;
  Index plane;

  VESTA_HD void operator()(Index i) const {
    if (mask[i] != 0) return;
    for (int c = 0; c < 3; ++c) image[c * plane + i] = from[c * plane + i];
  }
};
// The same, but sets the pixel to zero.
template <class S>
struct ClearWhereLeftOut {
  const std::uint8_t* mask;
  S* image;
  Index plane;

  VESTA_HD void operator()(Index i) const {
    if (mask[i] != 0) return;
    for (int c = 0; c < 3; ++c) image[c * plane + i] = S(0);
  }
};

}  // namespace vesta::gs
