// SPDX-License-Identifier: Apache-2.0
// Functors that change masked or transparent pixels (model/masked_loss.h), on host and device.
#pragma once

#include <cstdint>

#include "kernels/core/hd.h"
#include "kernels/core/span.h"

namespace vesta::gs {

// Copies pixel i of `from` to `image` if mask[i] is 0. Images have three planes of `plane` pixels.
template <class S>
struct FillMaskedPixels {
  const std::uint8_t* mask;
  const S* from;
  S* image;
  Index plane;

  VESTA_HD void operator()(Index i) const {
    if (mask[i] != 0) return;
    for (int c = 0; c < 3; ++c) image[c * plane + i] = from[c * plane + i];
  }
};
// Sets pixel i of `image` to zero if mask[i] is 0.
template <class S>
struct ClearMaskedPixels {
  const std::uint8_t* mask;
  S* image;
  Index plane;

  VESTA_HD void operator()(Index i) const {
    if (mask[i] != 0) return;
    for (int c = 0; c < 3; ++c) image[c * plane + i] = S(0);
  }
};

// Stores pixel i of `from` over another background. change: the new background minus the old one.
template <class S>
struct ChangeBackground {
  const S *from, *transparency;
  S change[3];
  S* image;
  Index plane;

  VESTA_HD void operator()(Index i) const {
    for (int c = 0; c < 3; ++c) image[c * plane + i] = from[c * plane + i] + change[c] * transparency[i];
  }
};

}  // namespace vesta::gs
