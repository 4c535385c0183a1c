// SPDX-License-Identifier: Apache-2.0
// A bundle adjustment as data, and its text files.
//
// The files are those of "Bundle adjustment in the large": a line `cameras points observations`, a line `camera point x
// y` for each observation, then the parameters, one a line (projection.h has their meaning).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kernels/core/span.h"

namespace vesta {
class AtomicFile;
}

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

// Throws Error, one line that names the file and the line at fault: not such a file, cut short, indices out of range,
// counts that the file cannot hold, numbers that are not finite, something after the last parameter.
BundleData ReadBal(const std::string& path);

// Written whole or not at all; reads back bit for bit. Throws Error where the file cannot be written.
void WriteBal(const std::string& path, const BundleData& data);
// The same into a file that is open, and stays so.
void WriteBal(AtomicFile& file, const BundleData& data);

}  // namespace vesta::bundle
