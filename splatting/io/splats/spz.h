// SPDX-License-Identifier: Apache-2.0
// Splats in .spz files: the compact format of Niantic Labs (github.com/nianticlabs/spz), 19 to 64 bytes a Gaussian and
// those compressed by gzip.
#pragma once

#include <string>
#include <string_view>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {

// Versions 1 to 3, SH degree 0 to 3; vesta's comments (splat_comments.h) are read from that of the gzip header. The
// flag for splats trained with antialiasing is passed over. Throws Error, one line with the file and what is wrong.
// What a header counts allocates nothing before the file has been found long enough to become it.
SplatModel ReadSpz(const std::string& path, const ReadSplatOptions& options = {});
// Of a file that has been read.
SplatModel ReadSpz(const std::string& path, std::string_view bytes, const ReadSplatOptions& options);

// Writes version 2, which all readers know, whole or not at all (atomic_file.h). Steps of what is stored:
//   means          2^-12 units as a rule; finer where Gaussians are small, coarser where means lie far out
//   log-scales     1/16 in -10..5.94
//   rotations      1/127.5 in x, y and z of a quaternion: of the 24 that mean the same Gaussian, with its log-scales in
//                  other places, the one that comes out nearest (cube_turns.h); 0.014 radians at most
//   opacities      1/255 (opacity_byte.h)
//   SH             coefficient 0: 0.026 in -3.33..3.33; the others: 1/128 in -1..0.99
// What lies beyond is clamped, but throws Error, one line with the file, where a step of the means is longer than half
// of the Gaussians are wide, half of them are larger or smaller than log-scales go, or a value is not finite.
void WriteSpz(const std::string& path, const SplatModel& model);

}  // namespace vesta::gs
