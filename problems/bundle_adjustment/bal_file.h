// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment data and its text file format.
//
// The format is BAL, from "Bundle adjustment in the large": a line `cameras points observations`, a line `camera point
// x y` per observation, then one parameter per line (see projection.h for their meaning).
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
  // Pixels from the centre of the image, as in projection.h.
  double pixel[2] = {0, 0};
};

struct BundleData {
  Index num_cameras = 0;
  Index num_points = 0;
  std::vector<Observation> observations;
  // Nine parameters per camera (angle-axis 3, translation 3, f, k1, k2), then three per point.
  std::vector<double> x;
};

// Throws Error with one line that names the file and the line at fault: not a BAL file, truncated, index out of range,
// counts too large for the file, a number that is not finite, or text after the last parameter.
BundleData ReadBal(const std::string& path);

// Writes the complete file or none; it reads back bit for bit. Throws Error if the file cannot be written.
void WriteBal(const std::string& path, const BundleData& data);
// The same into an open file, which stays open.
void WriteBal(AtomicFile& file, const BundleData& data);

}  // namespace vesta::bundle
