// SPDX-License-Identifier: Apache-2.0
// Synthetic bundle adjustment problems with a known solution.
#pragma once

#include <cstdint>

#include "problems/bundle_adjustment/bal_file.h"

namespace vesta::bundle {

// A vehicle drives down a street and then once around a block of houses, which closes the loop; with fewer than 210
// cameras, only part of the way around. The cameras look sideways and diagonally forward. The points are on the facades
// to the left and right. A camera can observe a point that is near enough, not at a grazing angle to its facade, and
// inside the image. A random sequence of consecutive such cameras observes the point: its track. Most tracks are short,
// a few are very long.
struct GenerateOptions {
  Index num_cameras = 100;   // at least 8
  Index num_points = 10000;  // at least 1
  double mean_track = 8;     // mean observations per point, if enough cameras can observe the points; at least 2
  double pixel_noise = 0.5;  // standard deviation of the observations, pixels
  double outliers = 0;       // fraction of observations with a noise of 30 pixels; in [0, 1]
  double start_noise = 1;    // factor on the noise of the starting parameters
  double start_drift = 1;    // factor on the drift of the starting positions; 1: about 1 % of the path length
  std::uint64_t seed = 1;
};

// x is the noisy start. Throws Error for options out of range. The result does not depend on the number of threads.
BundleData Generate(const GenerateOptions& options);

}  // namespace vesta::bundle
