// SPDX-License-Identifier: Apache-2.0
// Bundle adjustments made up from a known answer, for tests and benchmarks.
#pragma once

#include <cstdint>

#include "problems/bundle_adjustment/bal_file.h"

namespace vesta::bundle {

// A vehicle drives down a street and then once around a block of houses, which closes the loop (with 210 cameras or
// more; fewer go around a part of it). Cameras look to both sides, square and oblique; points lie on the facades to the
// left and right. A point is seen within a distance, within an angle to its facade, and inside the image; Of the
// cameras that could see it, a run of consecutive ones does. The lengths of the runs have a long tail: most tracks are
// short, a few are very long.
struct GenerateOptions {
  Index num_cameras = 100;   // at least 8
  Index num_points = 10000;  // at least 1
  double mean_track = 8;     // observations a point, on average, as far as the geometry allows; at least 2
  double pixel_noise = 0.5;  // standard deviation
  double outliers = 0;       // share of observations moved by some tens of pixels; within [0, 1]
  double start_noise = 1;    // factor on the noise of the starting parameters; 0: the true ones
  double start_drift = 1;    // factor on the drift along the way of the starting positions, about 1 % of it
  std::uint64_t seed = 1;
};

// Throws Error for options out of range. The result depends on the options alone, not on the number of threads.
BundleData Generate(const GenerateOptions& options);

}  // namespace vesta::bundle
