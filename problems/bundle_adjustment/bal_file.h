// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment data and its text format BAL (Agarwal et al., Bundle adjustment in the large, 2010).
//
// The first line has the numbers of cameras, points and observations. Then each observation has a line `camera point x
// y`: indices from 0, and a position in pixels. Then each parameter has a line: nine per camera (projection.h), then
// three per point.
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
  // Pixels from the image centre.
  double pixel[2] = {0, 0};
};

struct BundleData {
  Index num_cameras = 0;
  Index num_points = 0;
  std::vector<Observation> observations;
  // Nine parameters per camera (angle-axis 3, translation 3, f, k1, k2), then three per point.
  std::vector<double> x;
};

// Throws Error, naming file and line, if the file is not BAL, is too short for its counts, or has an index out of
// range, a number that is not finite, or text after the last parameter.
BundleData ReadBal(const std::string& path);

// Writes the complete file, or none. ReadBal returns the same bits. Throws Error if the file cannot be written.
void WriteBal(const std::string& path, const BundleData& data);
// Writes to an open file, which the caller commits.
void WriteBal(AtomicFile& file, const BundleData& data);

}  // namespace vesta::bundle
