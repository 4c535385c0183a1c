// SPDX-License-Identifier: Apache-2.0
// Pixels as an exposure changes them, for every memory space.
#pragma once

#include "kernels/core/hd.h"
#include "kernels/core/span.h"

namespace vesta::gs {

// A number for each channel.
template <class S>
struct Channels {
  static constexpr int kCount = 3;
  S of[kCount];
};

// By pixel, of an image of three planes: gain value + offset.
template <class S>
struct ExposePixel {
  Channels<S> gain, offset;
  S* image;
  Index plane;

  VESTA_HD void operator()(Index i) const {
    for (int c = 0; c < Channels<S>::kCount; ++c) {
      image[c * plane + i] = gain.of[c] * image[c * plane + i] + offset.of[c];
    }
  }
};

template <class S>
struct ScalePixel {
  Channels<S> factor;
  S* image;
  Index plane;

  VESTA_HD void operator()(Index i) const {
    for (int c = 0; c < Channels<S>::kCount; ++c) image[c * plane + i] *= factor.of[c];
  }
};

// The derivative of gain rendered + offset: d_image, of what is rendered, becomes that of what is shown.
template <class S>
struct ExposeChange {
  Channels<S> gain, d_gain, d_offset;
  const S* rendered;
  S* d_image;
  Index plane;

  VESTA_HD void operator()(Index i) const {
    for (int c = 0; c < Channels<S>::kCount; ++c) {
      S& d = d_image[c * plane + i];
      d = gain.of[c] * d + (d_gain.of[c] * rendered[c * plane + i] + d_offset.of[c]);
    }
  }
};

}  // namespace vesta::gs
