// SPDX-License-Identifier: Apache-2.0
// What an exposure (affine_color.h) does to images of three planes, for every memory space.
#pragma once

#include <array>

#include "kernels/core/for_each.h"
#include "splatting/cameras/unknowns/exposed_pixels.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

inline constexpr Index kExposureGrain = 1 << 14;  // pixels

template <class S>
Channels<S> ChannelsOf(const std::array<double, 3>& values) {
  return {{static_cast<S>(values[0]), static_cast<S>(values[1]), static_cast<S>(values[2])}};
}

// image, in the memory of B, becomes what the exposure makes of it.
template <class B>
void Expose(const AffineColor& color, typename B::VectorView image) {
  using S = typename B::Scalar;
  const Index plane = image.size() / Channels<S>::kCount;
  ForEach<typename B::Space>(
      plane, kExposureGrain,
      ExposePixel<S>{ChannelsOf<S>(color.gain), ChannelsOf<S>(color.offset), image.data(), plane});
}
// image *= factors, channel by channel.
template <class B>
void ScaleChannels(const Channels<typename B::Scalar>& factors, typename B::VectorView image) {
  using S = typename B::Scalar;
  const Index plane = image.size() / Channels<S>::kCount;
  ForEach<typename B::Space>(plane, kExposureGrain, ScalePixel<S>{factors, image.data(), plane});
}

}  // namespace vesta::gs
