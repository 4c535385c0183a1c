// SPDX-License-Identifier: Apache-2.0
// A bundle adjustment as data: the observations and the parameters.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::bundle {

struct Observation {
  std::int32_t camera = 0;
  std::int32_t point = 0;
  // Pixels from the centre of the image, as projection.h has them.
  double pixel[2] = {0, 0};
};

struct BundleData {
  Index num_cameras = 0;
  Index num_points = 0;
  std::vector<Observation> observations;
  // The cameras, nine parameters each (angle-axis 3, translation 3, f, k1, k2), then the points, three each.
  std::vector<double> x;
};

}  // namespace vesta::bundle
