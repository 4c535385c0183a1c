// SPDX-License-Identifier: Apache-2.0
// Scales of colours.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace vesta::gs {

// The colour at `of`, 0..1, of a scale whose colours (r, g, b) are given at equal distances.
template <std::size_t N>
std::array<float, 3> OnScale(const std::array<std::array<float, 3>, N>& colors, float of) {
  const float at = of * static_cast<float>(N - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(at), N - 2);
  std::array<float, 3> color;
  for (std::size_t c = 0; c < 3; ++c) {
    color[c] = std::lerp(colors[below][c], colors[below + 1][c], at - static_cast<float>(below));
  }
  return color;
}

// From violet by teal, in the middle, to yellow: lighter at each step.
inline constexpr std::array<std::array<float, 3>, 5> kVioletToYellow = {{{0.20f, 0.05f, 0.30f},
                                                                         {0.22f, 0.25f, 0.58f},
                                                                         {0.10f, 0.52f, 0.58f},
                                                                         {0.40f, 0.76f, 0.38f},
                                                                         {0.99f, 0.92f, 0.30f}}};

}  // namespace vesta::gs
