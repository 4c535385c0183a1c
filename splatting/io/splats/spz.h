// SPDX-License-Identifier: Apache-2.0
// .spz files: the compact format of Niantic Labs (github.com/nianticlabs/spz), 19 to 64 bytes per Gaussian, compressed
// with gzip.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {

// Reads a splat of format version 1 to 3 with SH degree 0 to 3. vesta's comments (SplatComments) are read from the
// comment of the gzip header. The flag for splats trained with antialiasing is ignored. Throws Error, in one line with
// the file and the problem, if the file is damaged or not supported. The number of Gaussians in the header is checked
// against the length of the file before memory is allocated.
SplatModel ReadSpz(const std::string& path, std::vector<std::string>* notes = nullptr);
// bytes: the content of the file.
SplatModel ReadSpz(const std::string& path, std::string_view bytes, std::vector<std::string>* notes);

// Writes format version 2, which all readers support, completely or not at all (kernels/core/files.h). Quantisation
// steps:
//   means          2^-12 units; smaller if the Gaussians are small, larger if means are far from the origin
//   log-scales     1/16 in -10..5.94
//   rotations      1/127.5 in x, y and z of a quaternion (error at most 0.014 radians); of the 24 quaternions for
//                  the same Gaussian (CubeTurns), the one with the smallest error is written
//   opacities      1/255 (packed_values.h)
//   SH             coefficient 0: 0.026 in -3.33..3.33; the others: 1/128 in -1..0.99
// Values outside these ranges are clamped. Throws Error, with the file, if a value is not finite, if the step of the
// means exceeds the median size of the Gaussians, or if half of the Gaussians are too large or too small for the range
// of log-scales.
void WriteSpz(const std::string& path, const SplatModel& model);

// One of the 24 rotations that map the coordinate axes to each other. A Gaussian's principal axes can be permuted and
// reversed in 24 ways, so 24 quaternions describe it.
struct CubeTurn {
  std::array<double, 4> quaternion;  // w, x, y, z; unit
  // The Gaussian with quaternion q and log-scales s equals the one with Product(q, quaternion) and s[axes[0]],
  // s[axes[1]], s[axes[2]].
  std::array<int, 3> axes;
};

// The first is the identity.
const std::array<CubeTurn, 24>& CubeTurns();

// p q of quaternions w, x, y, z: rotates by q first, then by p.
std::array<double, 4> Product(const std::array<double, 4>& p, const std::array<double, 4>& q);

}  // namespace vesta::gs
