// SPDX-License-Identifier: Apache-2.0
// How the cameras of a scene stand together.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// The upper one of an even number. There must be one.
template <class T>
T Median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The mean of their centres, and the distance of the farthest from it, world units; 0 where all coincide.
struct CameraSpread {
  std::array<double, 3> mean{};
  double radius = 0;
};
CameraSpread SpreadOf(const std::vector<const View*>& views);

// The sum of their upward axes in the world; near 0 where they share none.
std::array<double, 3> SumOfUps(const std::vector<View>& views);

// What an image shows from left to right, degrees.
double HorizontalAngle(const Camera& camera);

}  // namespace vesta::gs
