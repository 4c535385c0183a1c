// SPDX-License-Identifier: Apache-2.0
// What the loss of a view would be were a splat of another colour c', of each splat by itself. Its pixels would change
// by exactly delta = w (c' - c), w = alpha T; what that does to the loss: loss_of_change.h.
#pragma once

namespace vesta::splat {

inline constexpr int kRecolors = 3;  // that are asked for at a time: of the lower degrees of the harmonics

// Of one splat.
template <class S>
struct Recolors {
  S color[kRecolors][3];  // after the clamp at 0
};
// Of one splat, summed over pixels and channels.
template <class S>
struct RecolorRises {
  S rise[kRecolors];  // of the loss when the splat has that colour
};

// Of one splat, by channel: the second derivative of the loss by its colour.
template <class S>
struct ColorCurvature {
  S channel[3];
};

}  // namespace vesta::splat
