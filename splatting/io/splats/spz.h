// SPDX-License-Identifier: Apache-2.0
// Splats in .spz files: the compact format of Niantic Labs (github.com/nianticlabs/spz), 19 to 64 bytes a Gaussian and
// those compressed by gzip.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {

// Versions 1 to 3, SH degree 0 to 3; vesta's comments (SplatComments) are read from that of the gzip header. The
// flag for splats trained with antialiasing is passed over. Throws Error, one line with the file and what is wrong.
// What a header counts allocates nothing before the file has been found long enough to become it.
SplatModel ReadSpz(const std::string& path, const ReadSplatOptions& options = {});
// Of a file that has been read.
SplatModel ReadSpz(const std::string& path, std::string_view bytes, const ReadSplatOptions& options);

// Writes version 2, which all readers know, whole or not at all (kernels/core/files.h). Steps of what is stored:
//   means          2^-12 units as a rule; finer where Gaussians are small, coarser where means lie far out
//   log-scales     1/16 in -10..5.94
//   rotations      1/127.5 in x, y and z of a quaternion: of the 24 that mean the same Gaussian, with its log-scales in
//                  other places, the one that comes out nearest (CubeTurns); 0.014 radians at most
//   opacities      1/255 (packed_values.h)
//   SH             coefficient 0: 0.026 in -3.33..3.33; the others: 1/128 in -1..0.99
// What lies beyond is clamped, but throws Error, one line with the file, where a step of the means is longer than half
// of the Gaussians are wide, half of them are larger or smaller than log-scales go, or a value is not finite.
void WriteSpz(const std::string& path, const SplatModel& model);

// The 24 rotations that bring axes onto axes. A Gaussian's principal axes may be named and directed in as many ways,
// and its quaternion chosen among as many that mean the same.
struct CubeTurn {
  std::array<double, 4> quaternion;  // w, x, y, z; unit
  // Gaussian with quaternion q and log-scales s is that with Product(q, quaternion) and log-scales s[axes[0]],
  // s[axes[1]], s[axes[2]].
  std::array<int, 3> axes;
};

// The first is no turn.
const std::array<CubeTurn, 24>& CubeTurns();

// p q of quaternions w, x, y, z: first the rotation of q, then that of p.
std::array<double, 4> Product(const std::array<double, 4>& p, const std::array<double, 4>& q);

}  // namespace vesta::gs
