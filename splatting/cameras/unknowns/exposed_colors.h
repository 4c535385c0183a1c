// SPDX-License-Identifier: Apache-2.0
// Applies exposures (AffineColor) to images of three planes, in any memory space.
#pragma once

#include <array>

#include "kernels/core/for_each.h"
#include "kernels/core/hd.h"
#include "kernels/core/span.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

template <class S>
struct Channels {
  static constexpr int kCount = 3;
  S of[kCount];
};

// Pixel i of three planes of `plane` pixels: value = gain * value + offset, per channel.
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

// Pixel i: value *= factor of the channel.
template <class S>
struct ScalePixel {
  Channels<S> factor;
  S* image;
  Index plane;

  VESTA_HD void operator()(Index i) const {
    for (int c = 0; c < Channels<S>::kCount; ++c) image[c * plane + i] *= factor.of[c];
  }
};

// Derivative of the exposed image, gain * rendered + offset, at pixel i. d_image: before the call, the change of
// `rendered`; afterwards, the change of the exposed image.
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

inline constexpr Index kExposureGrain = 1 << 14;  // pixels

template <class S>
Channels<S> ChannelsOf(const std::array<double, 3>& values) {
  return {{static_cast<S>(values[0]), static_cast<S>(values[1]), static_cast<S>(values[2])}};
}

// Changes the image in place.
template <class B>
void Expose(const AffineColor& color, typename B::VectorView image) {
  using S = typename B::Scalar;
  const Index plane = image.size() / Channels<S>::kCount;
  ForEach<typename B::Space>(
      plane, kExposureGrain,
      ExposePixel<S>{ChannelsOf<S>(color.gain), ChannelsOf<S>(color.offset), image.data(), plane});
}
// Multiplies each channel by its factor.
template <class B>
void ScaleChannels(const Channels<typename B::Scalar>& factors, typename B::VectorView image) {
  using S = typename B::Scalar;
  const Index plane = image.size() / Channels<S>::kCount;
  ForEach<typename B::Space>(plane, kExposureGrain, ScalePixel<S>{factors, image.data(), plane});
}

}  // namespace vesta::gs
