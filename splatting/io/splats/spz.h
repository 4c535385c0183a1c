// SPDX-License-Identifier: Apache-2.0
// .spz files: the compact format of Niantic Labs (github.com/nianticlabs/spz), 19 to 65 bytes per Gaussian before
// compression.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/spz_file.h"

namespace vesta::gs {

// True for version 4, and for all gzip archives: versions 1 to 3.
bool IsSpz(std::string_view bytes);

// Reads a splat of format version 1 to 4 with SH degree 0 to 4; band 4 is left out, with a note. Throws Error, in one
// line with the file and the problem, if the file is damaged or not supported.
SplatModel ReadSpz(const std::string& path, std::vector<std::string>* notes = nullptr);
// bytes: the content of the file.
SplatModel ReadSpz(const std::string& path, std::string_view bytes, std::vector<std::string>* notes);

// The oldest version that can be written, for programs that do not read kLatestSpz.
inline constexpr std::uint32_t kUniversalSpz = 2;

// Writes a splat, completely or not at all (kernels/core/files.h). Quantisation steps:
//   means          2^-12 units; smaller if the Gaussians are small, larger if means are far from the origin
//   log-scales     1/16 in -10..5.94
//   rotations      spz_rotation.h
//   opacities      1/255 (packed_values.h)
//   SH             coefficient 0: 0.026 in -3.33..3.33; the others: 1/128 in -1..0.99
// Values outside these ranges are clamped. Throws Error, with the file, if a value is not finite, if the step of the
// means exceeds the median size of the Gaussians, or if half of the Gaussians are too large or too small for the range
// of log-scales. version: kLatestSpz or kUniversalSpz.
void WriteSpz(const std::string& path, const SplatModel& model, std::uint32_t version = kLatestSpz);

}  // namespace vesta::gs
